#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "formats/map/container/container_writer.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/map/repair/repair.h"
#include "formats/reader/look_up.h"
#include "formats/reader/map_container.h"
#include "formats/reader/reader.h"
#include "tests/formats/map/random_map.h"
#include "tests/formats/map/resealed.h"
#include "tests/support/value_of.h"

// Which maps a program reads that another version of it wrote. No version has been released, so
// the older and the newer minor are made up here: program 1.2 before maps of 1.1 and 1.3.

namespace sightline {
namespace {

using testing::HasSubstr;
constexpr FormatVersion kProgram{1, 2};

const CompiledMap& some_map() {
  static const CompiledMap kMap = random_map({.seed = 1, .site_count = 5, .nd_count = 5});
  return kMap;
}

std::vector<std::byte> of_version(const std::vector<std::byte>& file, FormatVersion version) {
  return with_header(file, [&](FileHeader& header) { header.version = version; });
}

BlockParts unknown_block(const std::string& name, bool is_required) {
  return {name, 3, is_required, 1, true, std::vector<std::byte>(100)};
}

// All that a map may lack: what the made-up 1.2 added.
std::vector<std::byte> map_of_1_1() {
  CompiledMap map = some_map();
  map.sharpness.reset();
  map.trajectory.reset();
  map.factors = {};
  map.model.bytes.clear();
  return of_version(encode_map(map), {1, 1});
}

// What a later minor may add: features, layers and sections that may be ignored.
ContainerParts parts_of_1_3() {
  ContainerParts parts = parts_of(some_map());
  parts.features = {{5, false, "seasons"}};
  parts.tiles[0].layers.insert(parts.tiles[0].layers.begin(), unknown_block("curbs", false));
  parts.sections.insert(parts.sections.begin(), unknown_block("access", false));
  parts.sections.push_back(unknown_block("weather", false));  // its name is after "look-up"
  return parts;
}

std::vector<std::byte> map_of_1_3(const ContainerParts& parts) {
  return of_version(assemble(parts), {1, 3});
}

void expect_opens(const std::vector<std::byte>& file) {
  for (const FormatVersion program : {kFormatVersion, kProgram}) {
    const MapFront front = value_of(open_front(file, program));
    require(open_directory(front));
    const LookUp look_up = value_of(LookUp::open(front));
  }
}

void expect_answers_of(const CompiledMap& map, const std::vector<std::byte>& file) {
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  for (std::uint32_t site = 0; site < map.sites.sites.size(); ++site) {
    const Eigen::Vector3d p_m = map.sites.sites[site].p_map_m + map.sites.frame.origin_world_m;
    const RangeAnswer answer = value_of(
        reader.observation_range({p_m.x(), p_m.y(), p_m.z()}, map.ranges.promises[0].limit_m));
    EXPECT_EQ(answer.site, site);
    EXPECT_EQ(answer.range_m, map.ranges.range_m(site, 0));
  }
}

std::string refusal(const std::vector<std::byte>& file, ErrorCode code) {
  const Result<MapReader> reader = MapReader::open(file, "annealed");
  const Result<CompiledMap> map = read_map(file);
  const Result<Recovered> recovered = recover_map(file);
  EXPECT_FALSE(reader || map || recovered);
  if (reader || map || recovered) return "";
  EXPECT_EQ(reader.error().code, code) << to_string(reader.error());
  EXPECT_EQ(map.error().code, code) << to_string(map.error());
  EXPECT_EQ(recovered.error().code, code) << to_string(recovered.error());
  return to_string(reader.error());
}

TEST(FormatVersion, OfAProgramReadsEveryMinorOfItsOwnMajorAndNoOtherMajor) {
  for (std::uint16_t minor = 0; minor < 5; ++minor) {
    EXPECT_TRUE(can_read(kProgram, {1, minor}));
    EXPECT_FALSE(can_read(kProgram, {0, minor}));
    EXPECT_FALSE(can_read(kProgram, {2, minor}));
  }
}

TEST(FormatVersion, OfAWrittenMapIsThatOfTheProgram) {
  const std::vector<std::byte> file = encode_map(some_map());
  EXPECT_EQ(decode_header(file)->version, kFormatVersion);
  EXPECT_EQ(verify_map(file)->format, "1.0");
}

TEST(FormatVersion, OlderInItsMinorReadsWithoutWhatWasAddedSince) {
  const std::vector<std::byte> file = map_of_1_1();
  expect_opens(file);
  expect_answers_of(some_map(), file);
  const CompiledMap map = value_of(read_map(file));
  EXPECT_FALSE(map.sharpness || map.trajectory);
  EXPECT_EQ(map.ndt.nds.size(), some_map().ndt.nds.size());
}

TEST(FormatVersion, NewerInItsMinorReadsAndSkipsWhatIsOptionalAndUnknown) {
  const std::vector<std::byte> file = map_of_1_3(parts_of_1_3());
  expect_opens(file);
  expect_answers_of(some_map(), file);
  const MapSummary summary = value_of(verify_map(file));
  EXPECT_EQ(summary.format, "1.3");
  EXPECT_EQ(summary.root_digest, decode_header(encode_map(some_map()))->root_digest);
  for (const char* name : {"curbs", "access", "weather"}) {
    EXPECT_EQ(std::ranges::count(summary.blocks, name, &MapSummary::Blocks::name), 1) << name;
  }
}

TEST(FormatVersion, NewerInItsMinorIsRefusedByTheNameOfARequiredFeature) {
  ContainerParts parts = parts_of_1_3();
  parts.features.push_back({63, true, "curved-cells"});
  EXPECT_THAT(refusal(map_of_1_3(parts), ErrorCode::kUnknownRequiredFeature),
              HasSubstr("curved-cells"));
}

TEST(FormatVersion, NewerInItsMinorIsRefusedByTheNameOfARequiredSection) {
  ContainerParts parts = parts_of_1_3();
  parts.sections.back().is_required = true;
  const std::vector<std::byte> file = map_of_1_3(parts);
  const Result<MapReader> reader = MapReader::open(file, "annealed");
  const Result<CompiledMap> map = read_map(file);
  ASSERT_FALSE(reader || map);
  for (const Error& error : {reader.error(), map.error()}) {
    EXPECT_EQ(error.code, ErrorCode::kUnknownRequiredFeature);
    EXPECT_THAT(to_string(error), HasSubstr("weather"));
  }
}

TEST(FormatVersion, OfALaterMajorIsRefusedAndTheMessageNamesWhoWroteIt) {
  EXPECT_THAT(refusal(of_version(encode_map(some_map()), {2, 1}), ErrorCode::kFutureVersion),
              HasSubstr("written by sightline test, format 2.1, this program reads 1.0. Compile "
                        "again, or use that version"));
}

TEST(FormatVersion, OfAnEarlierMajorIsRefusedAndTheMessageNamesWhoWroteIt) {
  EXPECT_THAT(refusal(of_version(encode_map(some_map()), {0, 9}), ErrorCode::kOldVersion),
              HasSubstr("written by sightline test, format 0.9, this program reads 1.0. Compile "
                        "again, or use that version"));
  const Error refused = failure_of(open_front(encode_map(some_map()), {2, 4}));
  EXPECT_EQ(refused.code, ErrorCode::kOldVersion);
  EXPECT_THAT(refused.message, HasSubstr("format 1.0, this program reads 2.4"));
}

TEST(FormatVersion, OfAnotherMajorIsRefusedAlsoWhereNothingElseCanBeRead) {
  const std::vector<std::byte> file = with_header(encode_map(some_map()), [](FileHeader& header) {
    header.version = {9, 0};
    header.manifest_offset = 12345678901;
  });
  EXPECT_THAT(refusal(file, ErrorCode::kFutureVersion), HasSubstr("written by a later program"));
}

TEST(FormatVersion, OfAnotherMajorIsRefusedWithoutAWriterThatIsNoName) {
  for (const std::string& writer :
       {std::string(), std::string("two\nlines"), std::string(1000, 'x')}) {
    CompiledMap map = some_map();
    map.writer = writer;
    EXPECT_THAT(refusal(of_version(encode_map(map), {2, 0}), ErrorCode::kFutureVersion),
                HasSubstr("written by a later program, format 2.0"));
  }
}

}  // namespace
}  // namespace sightline

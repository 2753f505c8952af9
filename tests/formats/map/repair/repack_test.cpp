#include "formats/map/repair/repack.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/map/container/container_writer.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

std::vector<std::string> block_names(const MapSummary& summary) {
  std::vector<std::string> names;
  for (const MapSummary::Blocks& blocks : summary.blocks) names.push_back(blocks.name);
  return names;
}

std::string csv(const CompiledMap& map, const char* name) {
  return format_table(*dump(map, name), TableFormat::kCsv);
}

TEST(StripMap, DropsWhatEngineersNeedAndChangesNoOtherDigest) {
  const std::vector<std::byte> file = encode_map(random_map({.seed = 1}));
  const Repacked stripped = value_of(strip_map(file));
  const Result<MapSummary> before = verify_map(file);
  const MapSummary after = value_of(verify_map(stripped.file));
  EXPECT_EQ(after.root_digest, before->root_digest);
  EXPECT_EQ(after.model_digest, before->model_digest);
  EXPECT_THAT(block_names(after), testing::ElementsAre("contents", "look-up", "ndt", "range"));
  EXPECT_LT(after.file_size, before->file_size);
  const CompiledMap whole = value_of(read_map(file));
  const CompiledMap left = value_of(read_map(stripped.file));
  for (const char* name : {"nds", "sites", "predicted", "ranges"}) {
    EXPECT_EQ(csv(left, name), csv(whole, name));
  }
  EXPECT_TRUE(left.factors.factors.empty());
  EXPECT_TRUE(left.model.bytes.empty());
}

TEST(StripMap, OfAStrippedMapChangesNothing) {
  const Repacked once = value_of(strip_map(encode_map(random_map({.seed = 2}))));
  const Repacked twice = value_of(strip_map(once.file));
  EXPECT_EQ(twice.file, once.file);
  EXPECT_THAT(twice.actions, testing::ElementsAre("there was nothing to drop"));
}

TEST(StripMap, KeepsWhatIsOptionalAndUnknown) {
  ContainerParts parts = parts_of(random_map({.seed = 3}));
  parts.sections.push_back({"kerbs", 3, false, 1, true, std::vector<std::byte>(100)});
  std::ranges::sort(parts.sections, {}, &BlockParts::name);
  const Repacked stripped = value_of(strip_map(assemble(parts)));
  const MapSummary after = value_of(verify_map(stripped.file));
  EXPECT_THAT(block_names(after), testing::Contains("kerbs"));
}

TEST(StripMap, CopiesNoDamage) {
  std::vector<std::byte> file = encode_map(random_map({.seed = 4}));
  file[file.size() / 2] ^= std::byte{4};
  const Error refused = failure_of(strip_map(file));
  EXPECT_EQ(error_class(refused.code), ErrorClass::kCorrupt);
}

}  // namespace
}  // namespace sightline

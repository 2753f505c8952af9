#include "formats/map/repair/repair.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/map/container/container_writer.h"
#include "formats/map/container/contents_layer.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/map/site_columns.h"
#include "formats/reader/map_container.h"
#include "map_generated.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using testing::HasSubstr;

// Tiles of 16 m, so that there are many.
CompiledMap sample(std::uint64_t seed) {
  CompiledMap map = random_map(
      {.seed = seed, .site_count = 60, .nd_count = 60, .tile_m = 16.0, .has_columns = seed == 1});
  map.reach_m = 8.0;
  return map;
}

struct TileEnds {
  TileKey key;
  std::uint64_t end = 0;
  std::uint64_t nds = 0;
  std::uint64_t sites = 0;
};

std::vector<TileEnds> tile_ends(const std::vector<std::byte>& file) {
  const MapContainer container = *open_container(file);
  std::vector<TileEnds> ends;
  for (const schema::Tile* tile : *container.directory->tiles()) {
    TileEnds end{{tile->x(), tile->y()}};
    for (const schema::Block* block : *tile->layers()) {
      end.end = block->offset() + block->stored_size();
      if (block->name()->str() == "ndt") end.nds = block->row_count();
      if (block->name()->str() == "range") end.sites = block->row_count();
    }
    ends.push_back(end);
  }
  return ends;
}

TEST(RecoverMap, OfAWholeFileGivesTheSameFile) {
  const std::vector<std::byte> file = encode_map(sample(1));
  const Recovered recovered = value_of(recover_map(file));
  EXPECT_TRUE(recovered.lost.empty());
  EXPECT_EQ(encode_map(recovered.map), file);
}

TEST(RecoverMap, LeavesOutADamagedColumnAndNothingElse) {
  const CompiledMap map = sample(1);
  std::vector<std::byte> file = encode_map(map);
  const std::vector<std::byte> values = encode_column(map.columns[1]);
  *std::search(file.begin(), file.end(), values.begin(), values.end()) ^= std::byte{1};
  const Recovered recovered = value_of(recover_map(file));
  ASSERT_EQ(recovered.map.columns.size(), 1U);
  EXPECT_EQ(recovered.map.columns[0].values, map.columns[0].values);
  ASSERT_EQ(recovered.lost.size(), 1U);
  EXPECT_THAT(recovered.lost[0], HasSubstr("the column kind"));
}

// Cut anywhere: every tile that ends before the cut is there, no other, and the result is a map.
TEST(RecoverMap, OfACutFileKeepsEveryTileThatEndsBeforeTheCut) {
  const CompiledMap map = sample(2);
  const std::vector<std::byte> file = encode_map(map);
  const std::vector<TileEnds> ends = tile_ends(file);
  for (std::size_t size = 160; size < file.size(); size += 997) {
    std::uint64_t nds = 0;
    std::uint64_t sites = 0;
    for (const TileEnds& tile : ends) {
      if (tile.end > size) continue;
      nds += tile.nds;
      sites += tile.sites;
    }
    const Result<Recovered> recovered = recover_map(std::span(file).first(size));
    ASSERT_EQ(recovered.has_value(), sites > 0) << "cut at " << size;
    if (!recovered) continue;
    EXPECT_EQ(recovered->map.ndt.nds.size(), nds) << "cut at " << size;
    EXPECT_EQ(recovered->map.sites.sites.size(), sites) << "cut at " << size;
    EXPECT_FALSE(recovered->lost.empty());
    require(read_map(encode_map(recovered->map)));
  }
}

TEST(RecoverMap, KeepsWhatSitesSayAndTheirOrderAlongTheRoute) {
  const CompiledMap map = sample(3);
  const std::vector<std::byte> file = encode_map(map);
  const Result<Recovered> recovered = recover_map(std::span(file).first(file.size() / 3));
  ASSERT_TRUE(recovered) << to_string(recovered.error());
  std::size_t from = 0;
  for (std::size_t i = 0; i < recovered->map.sites.sites.size(); ++i) {
    const Eigen::Vector3d& p_m = recovered->map.sites.sites[i].p_map_m;
    while (from < map.sites.sites.size() && map.sites.sites[from].p_map_m != p_m) ++from;
    ASSERT_LT(from, map.sites.sites.size()) << "site " << i << " is unknown or out of order";
    EXPECT_EQ(recovered->map.predicted.mean(i, 1), map.predicted.mean(from, 1));
    EXPECT_EQ(recovered->map.ranges.range_m(i, 0), map.ranges.range_m(from, 0));
  }
  EXPECT_EQ(recovered->map.version, map.version + ", recovered");
  EXPECT_EQ(recovered->map.measurement.measured_site_count, 0u);
}

TEST(RecoverMap, OfADamagedTileLosesThatTileAndSaysWhich) {
  std::vector<std::byte> file = encode_map(sample(4));
  const std::vector<TileEnds> ends = tile_ends(file);
  const TileEnds& tile = ends[ends.size() / 2];
  file[tile.end - 1] ^= std::byte{1};
  const Recovered recovered = value_of(recover_map(file));
  EXPECT_EQ(recovered.map.sites.sites.size() + tile.sites, 60u);
  ASSERT_FALSE(recovered.lost.empty());
  EXPECT_THAT(recovered.lost[0], HasSubstr("tile " + std::to_string(tile.key.x) + "," +
                                           std::to_string(tile.key.y) + ": SL4003"));
}

TEST(RecoverMap, OfOneDamagedLayerOfFactorsLosesAllFactorsAndNothingElse) {
  const CompiledMap map = sample(8);
  std::vector<std::byte> file = encode_map(map);
  const MapContainer container = *open_container(file);
  for (const schema::Block* block : *container.directory->tiles()->Get(0)->layers()) {
    if (block->name()->str() == "factors") file[block->offset()] ^= std::byte{1};
  }
  const Recovered recovered = value_of(recover_map(file));
  EXPECT_THAT(recovered.lost, testing::ElementsAre(HasSubstr("the factors: SL4003")));
  EXPECT_TRUE(recovered.map.factors.factors.empty());
  EXPECT_EQ(recovered.map.sites.sites.size(), 60u);
  EXPECT_EQ(recovered.map.model.bytes, map.model.bytes);
}

TEST(RecoverMap, OfADamagedDirectoryLosesNoTile) {
  std::vector<std::byte> file = encode_map(sample(5));
  file[decode_header(file)->directory_offset + 40] ^= std::byte{1};
  const Recovered recovered = value_of(recover_map(file));
  EXPECT_EQ(recovered.map.sites.sites.size(), 60u);
  EXPECT_EQ(recovered.map.version, "2026.1");
  EXPECT_THAT(recovered.lost[0], HasSubstr("the directory: SL4003"));
}

TEST(RecoverMap, NeedsHeaderAndManifest) {
  const std::vector<std::byte> file = encode_map(sample(6));
  for (const std::size_t byte : {std::size_t{20}, std::size_t{200}}) {
    std::vector<std::byte> damaged = file;
    damaged[byte] ^= std::byte{1};
    EXPECT_EQ(failure_of(recover_map(damaged)).code, ErrorCode::kChecksumMismatch);
  }
  EXPECT_EQ(failure_of(recover_map(std::span(file).first(3000))).code, ErrorCode::kTruncatedFile);
}

TEST(RecoverMap, OfAFileDamagedAnywhereGivesAValidMapOrNone) {
  const std::vector<std::byte> file = encode_map(
      random_map({.seed = 7, .site_count = 6, .nd_count = 6, .tile_m = 64.0, .model_size = 40}));
  for (std::size_t i = 0; i < file.size(); i += 7) {
    std::vector<std::byte> damaged = file;
    damaged[i] ^= std::byte(1 << (i % 8));
    const Result<Recovered> recovered = recover_map(damaged);
    ASSERT_TRUE(!recovered || validate(recovered->map)) << "after a flip in byte " << i;
  }
}

TEST(ContentsLayer, ComesBackAsItWas) {
  const std::vector<std::byte> stored(10, std::byte{7});
  const std::vector<PackedBlock> layers = {
      {"ndt", 1, true, BlockCodec::kZstd, 4, 832, 5, sha256("ndt"), stored},
      {std::string(40, 'x'), 1, false, BlockCodec::kNone, 1, 10, 6, sha256("x"), stored},
      {"range", 2, false, BlockCodec::kNone, 9, 10, 7, sha256("range"), stored}};
  const std::vector<std::byte> bytes =
      encode_contents(contents_of({-3, 5}, sha256("tile"), layers));
  EXPECT_EQ(bytes.size(), 64u + 2u * 128u);
  const std::optional<TileContents> back = decode_contents(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->key, (TileKey{-3, 5}));
  EXPECT_EQ(back->digest, sha256("tile"));
  ASSERT_EQ(back->layers.size(), 2u);  // a name of more than 32 bytes is passed over
  EXPECT_EQ(back->layers[0].name, "ndt");
  EXPECT_EQ(back->layers[0].offset, bytes.size());
  EXPECT_EQ(back->layers[0].codec, BlockCodec::kZstd);
  EXPECT_EQ(back->layers[1].offset, bytes.size() + 128u);  // behind two blocks of one line each
  EXPECT_EQ(back->layers[1].row_count, 9u);
  EXPECT_FALSE(back->layers[1].is_required);
  EXPECT_EQ(back->layers[1].raw_digest, sha256("range"));
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::vector<std::byte> damaged = bytes;
    damaged[i] ^= std::byte(1 << (i % 8));
    EXPECT_FALSE(decode_contents(damaged)) << i;
    EXPECT_FALSE(decode_contents(std::span(bytes).first(i))) << i;
  }
}

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

TEST(StripMap, KeepsTheDigestsOfRecordingsAndNotTheirSketches) {
  CompiledMap map = random_map({.seed = 2});
  RecordingCard card{"mapping", "street", sha256("street"), std::vector<ScanSketch>(40)};
  map.recordings = RecordingCards{{card}};
  const std::vector<std::byte> file = encode_map(map);
  const Repacked stripped = value_of(strip_map(file));
  card.scans.clear();
  const CompiledMap left = value_of(read_map(stripped.file));
  ASSERT_TRUE(left.recordings);
  EXPECT_THAT(left.recordings->cards, testing::ElementsAre(card));
  EXPECT_EQ(value_of(verify_map(stripped.file)).root_digest, verify_map(file)->root_digest);
  EXPECT_EQ(value_of(strip_map(stripped.file)).file, stripped.file);
}

TEST(StripMap, KeepsWhatIsOptionalAndUnknown) {
  ContainerParts parts = parts_of(random_map({.seed = 3}));
  parts.sections.push_back({"kerbs", 3, false, 1, true, std::vector<std::byte>(100)});
  std::ranges::sort(parts.sections, {}, &BlockParts::name);
  const Repacked stripped = value_of(strip_map(assemble(parts)));
  EXPECT_THAT(block_names(value_of(verify_map(stripped.file))), testing::Contains("kerbs"));
}

TEST(StripMap, CopiesNoDamage) {
  std::vector<std::byte> file = encode_map(random_map({.seed = 4}));
  file[file.size() / 2] ^= std::byte{4};
  EXPECT_EQ(error_class(failure_of(strip_map(file)).code), ErrorClass::kCorrupt);
}

}  // namespace
}  // namespace sightline

#include "formats/map/tiles/map_tiles.h"

#include <gtest/gtest.h>

#include <string>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/scratch_folder.h"

namespace sightline {
namespace {

const CompiledMap& some_map() {
  static const CompiledMap map = random_map({.seed = 3, .nd_count = 300});
  return map;
}

std::string written(const std::vector<std::byte>& bytes, const std::string& name) {
  const std::filesystem::path path = scratch_folder() / (name + ".slmap");
  EXPECT_TRUE(write_file_atomically(path, bytes, IfExists::kReplace));
  return path.string();
}

TEST(MapTiles, ReadsTileByTileWhatReadMapReadsAtOnce) {
  const std::string path = written(encode_map(some_map()), "tiles");
  const Result<CompiledMap> whole = read_map(path);
  const Result<MapTiles> tiles = MapTiles::open(path);
  ASSERT_TRUE(whole && tiles);
  EXPECT_GT(tiles->keys().size(), 3u);
  EXPECT_EQ(tiles->head().measurement.leaf_m, whole->measurement.leaf_m);
  std::vector<Nd> nds;
  for (std::size_t i = 0; i < tiles->keys().size(); ++i) {
    const Result<std::vector<Nd>> of_tile = tiles->nds(i);
    ASSERT_TRUE(of_tile) << to_string(of_tile.error());
    for (const Nd& nd : *of_tile) {
      EXPECT_EQ(tile_of(nd.key, whole->ndt.cell_m, whole->ndt.tile_m), tiles->keys()[i]);
    }
    nds.insert(nds.end(), of_tile->begin(), of_tile->end());
  }
  ASSERT_EQ(nds.size(), whole->ndt.nds.size());
  for (std::size_t i = 0; i < nds.size(); ++i) {
    EXPECT_EQ(nds[i].key, whole->ndt.nds[i].key);
    EXPECT_EQ(nds[i].mean_m, whole->ndt.nds[i].mean_m);
    EXPECT_EQ(nds[i].eigenvectors, whole->ndt.nds[i].eigenvectors);
  }
}

// A byte anywhere in the file: either it is refused when it is opened, or at most one tile is.
TEST(MapTiles, NamesADamagedTileAndReadsTheOthers) {
  const std::vector<std::byte> good = encode_map(some_map());
  std::size_t named_count = 0;
  for (std::size_t at = 0; at < good.size(); at += good.size() / 60) {
    std::vector<std::byte> bytes = good;
    bytes[at] ^= std::byte{4};
    const Result<MapTiles> tiles = MapTiles::open(written(bytes, "damaged"));
    if (!tiles) continue;
    std::size_t bad_count = 0;
    for (std::size_t i = 0; i < tiles->keys().size(); ++i) {
      const Result<std::vector<Nd>> of_tile = tiles->nds(i);
      if (of_tile) continue;
      ++bad_count;
      const TileKey& key = tiles->keys()[i];
      const std::string tile = "tile " + std::to_string(key.x) + "," + std::to_string(key.y);
      EXPECT_TRUE(of_tile.error().place.starts_with(tile)) << to_string(of_tile.error());
      EXPECT_TRUE(of_tile.error().file.ends_with("damaged.slmap"));
    }
    EXPECT_LE(bad_count, 1u) << "byte " << at;
    named_count += bad_count;
  }
  EXPECT_GT(named_count, 5u);
}

}  // namespace
}  // namespace sightline

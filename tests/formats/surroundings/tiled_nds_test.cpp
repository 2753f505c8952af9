#include "formats/surroundings/tiled_nds.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "formats/base/random.h"
#include "formats/surroundings/nearby_nds.h"
#include "formats/tables/stored_table_writer.h"
#include "tests/support/no_large_files.h"
#include "tests/support/toy_world.h"

namespace sightline {
namespace {

std::vector<std::byte> sealed(const TiledNds& nds) {
  std::vector<std::byte> bytes;
  EXPECT_TRUE(visit_bytes(nds, [&](std::span<const std::byte> piece) -> Result<void> {
    bytes.insert(bytes.end(), piece.begin(), piece.end());
    return {};
  }));
  return bytes;
}

std::vector<std::byte> payload_of(const NdtMap& map) {
  ByteWriter writer;
  encode(map, writer);
  return writer.take();
}

NdtMap counted_map(int nd_count, double half_extent_m) {
  NdtMap map = random_ndt_map(1, nd_count, half_extent_m);
  map.sparse_cell_count = 3;
  map.degenerate_cell_count = 5;
  map.point_count = 70;
  return map;
}

TEST(TiledNds, HasTheBytesOfTheMapAndGivesItBack) {
  for (const int count : {1, 50, 3000}) {
    const NdtMap map = counted_map(count, 400.0);
    const TiledNds tiled = map;
    ASSERT_TRUE(validate(tiled));
    EXPECT_EQ(tiled.row_count(), map.nds.size());
    EXPECT_TRUE(to_bytes(*tiled.whole()) == to_bytes(map));
    EXPECT_TRUE(sealed(tiled) == to_bytes(map));
    EXPECT_EQ(payload_size(tiled), payload_of(map).size());
    EXPECT_EQ(dump(tiled)->rows, dump(map).rows);
    const Result<TiledNds> back = from_stored<TiledNds>(StoredBytes(to_bytes(map)));
    ASSERT_TRUE(back) << to_string(back.error());
    EXPECT_TRUE(sealed(*back) == to_bytes(map));
    EXPECT_EQ(back->tiles().size(), tiled.tiles().size());
  }
  EXPECT_TRUE(sealed(NdtMap()) == to_bytes(NdtMap()));
}

TEST(TiledNds, HasTilesThatHoldEachNdOnce) {
  const NdtMap map = counted_map(3000, 400.0);
  const TiledNds tiled = map;
  ASSERT_GT(tiled.tiles().size(), 20U);
  std::vector<Nd> all;
  for (const RowTile& tile : tiled.tiles()) {
    const NdtMap of_tile = *tiled.tile(tile);
    EXPECT_EQ(of_tile.nds.size(), tile.count);
    for (const Nd& nd : of_tile.nds) EXPECT_TRUE(tile_of(nd.key, 2.0, 64.0) == tile.key);
    all.insert(all.end(), of_tile.nds.begin(), of_tile.nds.end());
  }
  NdtMap again = map;
  again.nds = all;
  EXPECT_TRUE(to_bytes(again) == to_bytes(map));
}

// nds_over() of the whole map is the oracle.
TEST(TiledNds, FindsOverABoxWhatTheWholeMapHasThere) {
  const NdtMap map = counted_map(3000, 400.0);
  const TiledNds tiled = map;
  Random random(2);
  std::size_t found = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector2d low_m(random.uniform(-450.0, 400.0), random.uniform(-450.0, 400.0));
    const Eigen::AlignedBox2d box_m(
        low_m, low_m + Eigen::Vector2d(random.uniform(0.0, 200.0), random.uniform(0.0, 200.0)));
    const NdtMap near = *tiled.over(box_m);
    EXPECT_TRUE(to_bytes(near) == to_bytes(nds_over(map, box_m)));
    found += near.nds.size();
  }
  EXPECT_GT(found, 100U);
  EXPECT_TRUE(to_bytes(*tiled.over(Eigen::AlignedBox2d())) ==
              to_bytes(nds_over(map, Eigen::AlignedBox2d())));
}

TEST(TiledNds, AreWrittenTileByTileIntoAFileWhereMemoryIsShort) {
  const NdtMap map = counted_map(3000, 400.0);
  const TiledNds tiled = map;
  StoredTableWriter<NdtMap> writer(map, 1000);
  for (const RowTile& tile : tiled.tiles()) {
    ASSERT_TRUE(writer.append(*tiled.tile(tile)));
  }
  EXPECT_TRUE(sealed(*writer.take()) == to_bytes(map));
}

TEST(TiledNds, ReturnThatTheDiskIsFull) {
  const NdtMap map = counted_map(300, 100.0);
  const NoLargeFiles full_disk;
  StoredTableWriter<NdtMap> writer(map, 1000);
  const Result<void> written = writer.append(map);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kDiskFull);
}

TEST(TiledNds, AreRefusedCutShortOrDamagedAtEveryByte) {
  const std::vector<std::byte> bytes = to_bytes(counted_map(3, 100.0));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(from_stored<TiledNds>(StoredBytes(std::move(cut))));
    std::vector<std::byte> damaged = bytes;
    damaged[size] ^= std::byte{0x10};
    EXPECT_FALSE(from_stored<TiledNds>(StoredBytes(std::move(damaged)))) << size;
  }
}

// What one form takes the other takes too.
TEST(TiledNds, AnyPayloadIsRefusedOrAValidMap) {
  const std::vector<std::byte> payload = payload_of(counted_map(4, 100.0));
  int refused = 0;
  for (std::size_t bit = 0; bit < 8 * payload.size(); ++bit) {
    std::vector<std::byte> changed = payload;
    changed[bit / 8] ^= std::byte{1} << (bit % 8);
    ByteReader reader(changed);
    NdtMap whole;
    decode(reader, whole);
    const bool is_map = reader.at_end() && validate(whole).has_value();
    TiledNds found;
    EXPECT_EQ(open_payload(StoredBytes(changed), found).has_value(), is_map) << bit;
    if (!is_map) ++refused;
  }
  EXPECT_GT(refused, 500);
}

TEST(TiledNds, NameTheTileWhoseNdsAreOutOfOrder) {
  NdtMap map = counted_map(200, 30.0);
  ASSERT_GT(map.nds.size(), 3U);
  std::swap(map.nds[0], map.nds[1]);
  const Result<TiledNds> found = from_stored<TiledNds>(StoredBytes(to_bytes(map)));
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kInvalidArtifact);
  EXPECT_EQ(found.error().place.rfind("tile ", 0), 0U) << found.error().place;
}

}  // namespace
}  // namespace sightline

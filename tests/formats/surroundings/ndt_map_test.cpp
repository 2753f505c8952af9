#include "formats/surroundings/ndt_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "formats/base/random.h"
#include "formats/symmetric_eigen.h"
#include "formats/tables/stored_table_writer.h"
#include "tests/support/artifact_checks.h"
#include "tests/support/test_files.h"
#include "tests/support/toy_world.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

Nd nd_with_sigmas(double sigma1_m, double sigma2_m, double sigma3_m) {
  Nd nd;
  nd.eigenvalues_m2 = {sigma1_m * sigma1_m, sigma2_m * sigma2_m, sigma3_m * sigma3_m};
  return nd;
}

TEST(NdtMap, SurvivesDisk) {
  NdtMap map = random_ndt_map(1, 4, 6.0);
  map.frame.origin_world_m = {640.0, -128.0, 64.0};
  map.sparse_cell_count = 7;
  expect_survives_disk(map);
}

TEST(NdtMap, GivesTheSameEigenvectorsToTheBitAfterDisk) {
  const NdtMap map = random_ndt_map(2, 50, 30.0);
  const NdtMap back = value_of(from_bytes<NdtMap>(to_bytes(map)));
  for (std::size_t i = 0; i < map.nds.size(); ++i) {
    EXPECT_EQ(map.nds[i].eigenvectors, back.nds[i].eigenvectors);
    EXPECT_EQ(map.nds[i].eigenvalues_m2, back.nds[i].eigenvalues_m2);
  }
}

TEST(NdtMap, PutsAPointOnALowerFaceIntoTheCellAboveIt) {
  EXPECT_EQ(cell_key({2.0, -2.0, 0.0}, 2.0), (CellKey{1, -1, 0}));
  EXPECT_EQ(cell_key({1.9999999, -2.0000001, -1e-12}, 2.0), (CellKey{0, -2, -1}));
}

TEST(NdtMap, FloorsLikeTheLibraryForAnyNumber) {
  Random random(3);
  for (int i = 0; i < 10000; ++i) {
    const double value = random.uniform(-100.0, 100.0) * std::pow(10.0, random.uniform(-9.0, 6.0));
    ASSERT_EQ(floor_to_int(value), static_cast<std::int32_t>(std::floor(value))) << value;
  }
}

TEST(NdtMap, CountsTilesBelowZeroDownwards) {
  EXPECT_EQ(tile_of({0, 31, 5}, 2.0, 64.0), (TileKey{0, 0}));
  EXPECT_EQ(tile_of({32, -1, 5}, 2.0, 64.0), (TileKey{1, -1}));
  EXPECT_EQ(tile_of({-32, -33, 5}, 2.0, 64.0), (TileKey{-1, -2}));
}

TEST(NdtMap, OnlyWholeCellsMakeATile) {
  EXPECT_TRUE(is_tiling(2.0, 64.0));
  EXPECT_TRUE(is_tiling(0.1, 64.0));
  EXPECT_FALSE(is_tiling(3.0, 64.0));
  EXPECT_FALSE(is_tiling(64.0, 2.0));
  EXPECT_FALSE(is_tiling(0.0, 64.0));
}

TEST(NdtMap, ClassifiesByTheLargestOfEquationOneAndTheFirstOnATie) {
  EXPECT_EQ(dimension_class(nd_with_sigmas(1.0, 0.1, 0.05)), 1);
  EXPECT_EQ(dimension_class(nd_with_sigmas(1.0, 0.9, 0.05)), 2);
  EXPECT_EQ(dimension_class(nd_with_sigmas(1.0, 0.9, 0.8)), 3);
  EXPECT_EQ(dimension_class(nd_with_sigmas(1.0, 0.5, 0.0)), 1);    // linear equals planar
  EXPECT_EQ(dimension_class(nd_with_sigmas(1.0, 1.0, 0.5)), 2);    // planar equals round
  EXPECT_EQ(dimension_class(nd_with_sigmas(0.75, 0.5, 0.25)), 1);  // all three equal
}

TEST(NdtMap, RegularisationRaisesSmallEigenvaluesAndKeepsTheRest) {
  Random random(4);
  for (const Nd& nd : random_ndt_map(5, 100, 40.0).nds) {
    const Eigen::Matrix3d regularised = regularised_covariance_m2(nd);
    const SymmetricEigen<3> eigen = symmetric_eigen<3>(regularised);
    for (int i = 0; i < 3; ++i) {
      const double expected = std::max(nd.eigenvalues_m2[i], 0.01 * nd.eigenvalues_m2[0]);
      EXPECT_NEAR(eigen.values[2 - i], expected, 1e-12 * nd.eigenvalues_m2[0]);
      const Eigen::Vector3d scaled = expected * nd.eigenvectors.col(i);
      EXPECT_TRUE((regularised * nd.eigenvectors.col(i)).isApprox(scaled, 1e-9));
    }
    EXPECT_EQ(regularised, regularised.transpose());
  }
}

TEST(NdtMap, RefusesAMeanOutsideItsCell) {
  NdtMap map = random_ndt_map(6, 20, 20.0);
  map.nds[3].mean_m.x() += 2.0;
  EXPECT_EQ(failure_of(validate(map)).place, "nd 3");
}

TEST(NdtMap, RefusesCellsOutOfOrderAndNumbersThatAreNotFinite) {
  expect_refused<NdtMap>(random_ndt_map(7, 20, 20.0),
                         {[](NdtMap& map) { std::swap(map.nds[4], map.nds[5]); },
                          [](NdtMap& map) { map.nds[5] = map.nds[4]; },
                          [](NdtMap& map) { map.nds[0].covariance_m2(0, 1) = std::nan(""); },
                          [](NdtMap& map) { map.nds[0].mean_m.z() = 1e300; }});
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
    const TiledNds back = value_of(from_stored<TiledNds>(StoredBytes(to_bytes(map))));
    EXPECT_TRUE(sealed(back) == to_bytes(map));
    EXPECT_EQ(back.tiles().size(), tiled.tiles().size());
  }
  EXPECT_TRUE(sealed(TiledNds(NdtMap())) == to_bytes(NdtMap()));
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

NdtMap nds_over(const NdtMap& map, const Eigen::AlignedBox2d& box_m) {
  NdtMap near{map.frame, map.cell_m, map.tile_m, {}, 0, 0, 0};
  if (box_m.isEmpty()) return near;
  const TileKey low = tile_key({box_m.min().x(), box_m.min().y(), 0.0}, map.tile_m);
  const TileKey high = tile_key({box_m.max().x(), box_m.max().y(), 0.0}, map.tile_m);
  for (const Nd& nd : map.nds) {
    const TileKey tile = tile_of(nd.key, map.cell_m, map.tile_m);
    const bool is_near = low.x <= tile.x && tile.x <= high.x && low.y <= tile.y && tile.y <= high.y;
    if (is_near) near.nds.push_back(nd);
  }
  return near;
}

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
    for (const Nd& nd : near.nds) {
      EXPECT_LT(box_m.exteriorDistance(nd.mean_m.head<2>().eval()), 1.5 * map.tile_m);
    }
    found += near.nds.size();
  }
  EXPECT_GT(found, 100U);
  EXPECT_LT(found, 25 * map.nds.size());
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
  EXPECT_EQ(code_of(writer.append(map)), ErrorCode::kDiskFull);
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
  const Error error = failure_of(from_stored<TiledNds>(StoredBytes(to_bytes(map))));
  EXPECT_EQ(error.code, ErrorCode::kInvalidArtifact);
  EXPECT_EQ(error.place.rfind("tile ", 0), 0U) << error.place;
}

}  // namespace
}  // namespace sightline

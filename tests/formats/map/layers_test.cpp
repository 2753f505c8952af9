#include "formats/map/layers.h"

#include <gtest/gtest.h>

#include <numeric>

#include "formats/base/random.h"
#include "formats/reader/map_layout.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

NdtMap map_of_one(const Eigen::Vector3d& mean_m, double cell_m) {
  NdtMap ndt;
  ndt.cell_m = cell_m;
  ndt.tile_m = 32.0 * cell_m;
  Nd nd;
  nd.mean_m = mean_m;
  nd.key = cell_key(mean_m, cell_m);
  nd.point_count = 10;
  nd.covariance_m2.diagonal() << 0.5, 0.25, 1e-9;
  decompose(nd);
  ndt.nds.push_back(nd);
  return ndt;
}

Nd round_trip(const NdtMap& ndt) {
  const std::vector<std::uint32_t> rows = {0};
  const TileKey tile = tile_of(ndt.nds[0].key, ndt.cell_m, ndt.tile_m);
  const std::vector<std::byte> raw = encode_ndt_layer(ndt, rows);
  NdtMap back = ndt;
  back.nds.clear();
  EXPECT_TRUE(decode_ndt_layer(raw, 1, tile, back));
  EXPECT_TRUE(validate(back));
  EXPECT_EQ(encode_ndt_layer(back, rows), raw) << "not the same bytes a second time";
  return back.nds[0];
}

TEST(NdtLayer, KeepsAMeanOnAFaceInsideItsCell) {
  for (const double x_m :
       {0.0, std::nextafter(2.0, 0.0), -2.0, std::nextafter(-2.0, -3.0), 1e6 + 2.0 - 1e-10, -1e6}) {
    const NdtMap ndt = map_of_one({x_m, 0.3, -0.7}, 2.0);
    const Nd back = round_trip(ndt);
    EXPECT_EQ(back.key, ndt.nds[0].key);
    // On an upper face the nearest multiple is out of reach, so up to one whole unit is lost.
    EXPECT_LE(std::abs(back.mean_m.x() - x_m), 6e-8);
  }
}

TEST(NdtLayer, LosesAtMostThirtyNanometresAnywhere) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const double cell_m = i % 3 == 0 ? 2.0 : random.uniform(0.1, 3.0);
    const NdtMap ndt = map_of_one(
        {random.uniform(-1e5, 1e5), random.uniform(-1e5, 1e5), random.uniform(-100.0, 100.0)},
        cell_m);
    const Nd back = round_trip(ndt);
    EXPECT_LE((back.mean_m - ndt.nds[0].mean_m).cwiseAbs().maxCoeff(), 6.1e-8);
    EXPECT_LE((back.covariance_m2 - ndt.nds[0].covariance_m2).cwiseAbs().maxCoeff(), 3.1e-8);
  }
}

TEST(NdtLayer, RefusesACellOfAnotherTile) {
  const NdtMap ndt = map_of_one({1.0, 1.0, 1.0}, 2.0);
  const std::vector<std::uint32_t> rows = {0};
  NdtMap back = ndt;
  back.nds.clear();
  EXPECT_EQ(failure_of(decode_ndt_layer(encode_ndt_layer(ndt, rows), 1, {5, 0}, back)).code,
            ErrorCode::kBadOrder);
}

TEST(Tiles, HoldEveryNdAndEverySiteOnceInOrder) {
  for (const double tile_m : {16.0, 64.0}) {
    const CompiledMap map =
        random_map({.seed = 9, .site_count = 100, .nd_count = 200, .tile_m = tile_m});
    std::vector<std::uint32_t> nds;
    std::vector<std::uint32_t> sites;
    for (const TileRows& tile : tiles_of(map)) {
      nds.insert(nds.end(), tile.nds.begin(), tile.nds.end());
      sites.insert(sites.end(), tile.sites.begin(), tile.sites.end());
      EXPECT_TRUE(std::ranges::is_sorted(tile.sites));
      for (const std::uint32_t site : tile.sites) {
        const Eigen::Vector3d& p_m = map.sites.sites[site].p_map_m;
        EXPECT_EQ(std::floor(p_m.x() / tile_m), tile.key.x);
        EXPECT_EQ(std::floor(p_m.y() / tile_m), tile.key.y);
      }
    }
    // NDs are sorted by tile in memory already.
    std::vector<std::uint32_t> all(map.ndt.nds.size());
    std::iota(all.begin(), all.end(), 0u);
    EXPECT_EQ(nds, all);
    std::ranges::sort(sites);
    all.resize(map.sites.sites.size());
    std::iota(all.begin(), all.end(), 0u);
    EXPECT_EQ(sites, all);
  }
}

TEST(RangeLayout, PlacesColumnsSideBySideWithoutOverlap) {
  const RangeLayout layout(3, {9, 2, 4});
  EXPECT_EQ(layout.site, 0u);
  EXPECT_EQ(layout.run, 64u);
  EXPECT_EQ(layout.s, 128u);
  EXPECT_EQ(layout.p_x, 192u);
  EXPECT_EQ(layout.range_index, 384u);
  EXPECT_EQ(layout.range_flags, 448u);
  EXPECT_EQ(layout.mean_error, 512u);          // 3 x 9 x 8 = 216 bytes
  EXPECT_EQ(layout.probability, 512u + 256u);  // 432 bytes
  EXPECT_EQ(layout.site_flags, 512u + 256u + 448u);
  EXPECT_EQ(layout.extrapolated, 512u + 256u + 448u + 64u);
  EXPECT_EQ(layout.pose, 512u + 256u + 448u + 128u);  // 288 bytes
  EXPECT_EQ(layout.look_index, 512u + 256u + 448u + 128u + 320u);
  EXPECT_EQ(layout.look_flags, layout.look_index + 64u);
  EXPECT_EQ(layout.look_mean_error, layout.look_index + 128u);   // 96 bytes
  EXPECT_EQ(layout.look_probability, layout.look_index + 256u);  // 192 bytes
  EXPECT_EQ(layout.look_extrapolated, layout.look_index + 448u);
  EXPECT_EQ(layout.range_reason, layout.look_index + 512u);
  EXPECT_EQ(layout.look_reason, layout.look_index + 576u);
  EXPECT_EQ(layout.size, layout.look_index + 640u);
  EXPECT_EQ(RangeLayout(3, {9, 2, 0}).size, layout.look_index + 64u) << "nothing of looks";
  EXPECT_EQ(NdtLayout(17).size, 13u * 128u);
}

}  // namespace
}  // namespace sightline

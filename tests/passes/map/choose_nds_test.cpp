#include "passes/map/choose_nds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "formats/map/container/small_nd.h"
#include "tests/support/test_context.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

// Cells of 2 m around a route along x: walls, ground and bushes.
NdtMap street() {
  Random random(5);
  NdtMap map;
  for (int x = -60; x < 60; ++x) {
    for (int y = -60; y < 60; ++y) {
      if (random.below(3) != 0) continue;
      Nd nd;
      nd.key = {x, y, static_cast<std::int32_t>(random.below(3))};
      nd.point_count = static_cast<std::uint32_t>(10 + random.below(200));
      nd.mean_m = 2.0 * Eigen::Vector3d(nd.key.x + 0.5, nd.key.y + 0.5, nd.key.z + 0.5);
      Eigen::Vector3d variance_m2(0.3, 0.3, 0.3);
      variance_m2[static_cast<int>(random.below(3))] = random.uniform(1e-5, 0.1);
      nd.covariance_m2 = variance_m2.asDiagonal();
      map.nds.push_back(nd);
    }
  }
  const auto order = [&](const Nd& nd) {
    return std::pair(tile_of(nd.key, map.cell_m, map.tile_m), nd.key);
  };
  std::ranges::sort(map.nds, {}, order);
  decompose(std::span(map.nds));
  return map;
}

Sites route(double begin_m, double end_m) {
  Sites sites;
  for (double x_m = begin_m; x_m <= end_m; x_m += 1.0) {
    Site site;
    site.s_m = x_m - begin_m;
    site.p_map_m = {x_m, 0.0, 2.0};
    sites.sites.push_back(site);
  }
  return sites;
}

std::vector<CellKey> chosen(const NdtMap& map, const Sites& sites,
                            const ChooseNdsOptions& options = {}) {
  const TiledNds found = value_of(choose_nds(TestContext(2), options, map, sites));
  std::vector<CellKey> keys;
  for (const Nd& nd : value_of(found.whole()).nds) keys.push_back(nd.key);
  return keys;
}

TEST(ChooseNds, KeepsAllNearTheRouteAndNoneFarFromIt) {
  const NdtMap map = street();
  const std::vector<CellKey> keys = chosen(map, route(-50.0, 50.0));
  std::size_t thinned = 0;
  for (const Nd& nd : map.nds) {
    const double along_m = std::max(0.0, std::abs(nd.mean_m.x()) - 50.0);
    const double away_m = Eigen::Vector3d(along_m, nd.mean_m.y(), nd.mean_m.z() - 2.0).norm();
    const bool is_kept = std::ranges::find(keys, nd.key) != keys.end();
    if (away_m < 24.0) {
      EXPECT_TRUE(is_kept) << nd.mean_m.transpose();
    }
    if (away_m > 61.0) {
      EXPECT_FALSE(is_kept) << nd.mean_m.transpose();
    }
    thinned += away_m > 26.0 && away_m < 59.0 && !is_kept ? 1 : 0;
  }
  EXPECT_GT(thinned, map.nds.size() / 20);
}

TEST(ChooseNds, KeepsOfEachCubeTheSharpestOfADirection) {
  NdtMap map;
  for (const double variance_m2 : {0.02, 1e-5, 0.01}) {
    Nd nd;
    nd.key = {static_cast<std::int32_t>(map.nds.size()), 20, 0};
    nd.point_count = 50;
    nd.mean_m = 2.0 * Eigen::Vector3d(nd.key.x + 0.5, nd.key.y + 0.5, 0.5);
    nd.covariance_m2 = Eigen::Vector3d(0.3, variance_m2, 0.3).asDiagonal();
    decompose(nd);
    map.nds.push_back(nd);
  }
  EXPECT_THAT(chosen(map, route(-5.0, 5.0), {.per_direction = 1}),
              testing::ElementsAre(CellKey{1, 20, 0}));
}

TEST(ChooseNds, ChangesNothingFarFromAChange) {
  const NdtMap map = street();
  NdtMap changed = map;
  std::erase_if(changed.nds, [](const Nd& nd) { return nd.mean_m.x() > 60.0; });
  const std::vector<CellKey> before = chosen(map, route(-50.0, 50.0));
  const std::vector<CellKey> after = chosen(changed, route(-50.0, 50.0));
  for (const CellKey& key : before) {
    if (2.0 * (key.x + 1) > 56.0) continue;  // cubes of 8 m
    EXPECT_THAT(after, testing::Contains(key));
  }
}

TEST(ChooseNds, GivesWhatASmallMapStoresExactly) {
  const TiledNds found = value_of(choose_nds(TestContext(2), {}, street(), route(-50.0, 50.0)));
  EXPECT_TRUE(validate(found));
  const NdtMap whole = value_of(found.whole());
  for (const Nd& nd : whole.nds) {
    EXPECT_TRUE(small_of(row_of(nd, whole.cell_m), half_step_units(whole.cell_m)));
  }
}

TEST(ChooseNds, RefusesARouteBesideTheMap) {
  const Result<TiledNds> found = choose_nds(TestContext(1), {}, street(), route(5000.0, 5010.0));
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kEmptyMap);
}

}  // namespace
}  // namespace sightline

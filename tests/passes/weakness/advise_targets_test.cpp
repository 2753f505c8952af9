#include "passes/weakness/advise_targets.h"

#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

#include "formats/surroundings/cell_moments.h"
#include "passes/factors/virtual_scan.h"
#include "passes/matching/scan_preparation.h"
#include "tests/passes/weakness/corridor.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

std::vector<TargetAdvice> advice_of(const CorridorScene& scene, const AdviceOptions& options,
                                    int threads = 1) {
  const std::vector<double> weights = {30.0};
  const std::vector<double> std_m = {std_along_m(crlb(scene.views[0].information), 0.0)};
  return advise_targets(TestContext(threads), options,
                        {scene.nds, scene.sites, scene.views, std_m, weights, scene.directions,
                         scene.options, 1, 3, 0.0});
}

double from_wall_m(const Eigen::Vector3d& p_m) { return kCorridorWall_m - std::abs(p_m.y()); }

TEST(AdviseTargets, NamesPlacesBesideTheRoadOnTheGroundAndOffWalls) {
  const CorridorScene scene;
  const AdviceOptions options;
  const std::vector<TargetAdvice> found = advice_of(scene, options);
  ASSERT_EQ(found.size(), options.most);
  double before = 1.0;
  for (const TargetAdvice& one : found) {
    const Eigen::Vector3d& foot_m = one.target.foot_map_m;
    EXPECT_NEAR(foot_m.z(), kCorridorGround_m, 1e-6);
    EXPECT_GE(std::abs(one.beside_m), options.nearest_m);
    EXPECT_GT(from_wall_m(foot_m), options.clear_m + 0.5 * options.size.width_m - 0.05);
    EXPECT_GT(one.gain, 0.02);
    EXPECT_LE(one.gain, before);
    EXPECT_GT(one.return_count, 10U);
    EXPECT_NEAR(one.gain, 1.0 - one.std_after_m / one.std_before_m, 1e-12);
    EXPECT_DOUBLE_EQ(one.gain, one.gain_at_worst);  // one judged site
    EXPECT_NEAR(facing_deg(one.target), 0.0, 1e-9);
    before = one.gain;
    for (const TargetAdvice& other : found) {
      const double apart_m = (other.target.foot_map_m - foot_m).norm();
      EXPECT_TRUE(apart_m == 0.0 || apart_m >= options.apart_m);
    }
  }
}

TEST(AdviseTargets, NamesPlacesThatAreApart) {
  const CorridorScene scene;
  AdviceOptions wide;
  wide.apart_m = 15.0;
  const std::vector<TargetAdvice> found = advice_of(scene, wide);
  ASSERT_GT(found.size(), 1U);
  for (std::size_t i = 1; i < found.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_GE((found[i].target.foot_map_m - found[k].target.foot_map_m).norm(), 15.0);
    }
  }
}

TEST(AdviseTargets, GainsLessWhereAWallAcrossTheStreetHoldsItAnyway) {
  const double bare = advice_of(CorridorScene(false), {}).front().gain;
  EXPECT_LT(advice_of(CorridorScene(true), {}).front().gain, 0.8 * bare);
}

TEST(AdviseTargets, OfALargerBoardGainsMore) {
  const CorridorScene scene;
  AdviceOptions large;
  large.size = {2.0, 3.0, 0.5};
  EXPECT_GT(advice_of(scene, large).front().gain, advice_of(scene, {}).front().gain);
}

TEST(AdviseTargets, IsTheSameForAnyNumberOfThreads) {
  const CorridorScene scene;
  const std::vector<TargetAdvice> one = advice_of(scene, {}, 1);
  const std::vector<TargetAdvice> three = advice_of(scene, {}, 3);
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].target.foot_map_m, three[i].target.foot_map_m);
    EXPECT_EQ(one[i].gain, three[i].gain);
  }
}

TEST(AdviseTargets, AddsInformationToWhatTheMapsFactorsTell) {
  // 1 / 0.3^2 - 1 / 0.5^2 more, on 1 / 0.6^2.
  EXPECT_NEAR(std_with_more_m(0.6, 0.5, 0.3), 1.0 / std::sqrt(9.8888888889), 1e-9);
  EXPECT_NEAR(std_with_more_m(0.5, 0.5, 0.3), 0.3, 1e-12);
  EXPECT_EQ(std_with_more_m(0.5, 0.3, 0.3), 0.5);
  EXPECT_NEAR(std_with_more_m(1.0, 0.1, 0.5), 10.0, 1e-12);  // never below nothing
}

TEST(IsTaken, WhereAWallIsNearAndNotByTheGround) {
  const CorridorScene scene;
  Target target;
  target.foot_map_m = {40.0, 6.0, kCorridorGround_m};
  EXPECT_FALSE(is_taken(scene.nds, target, 0.7));  // 2.1 m, of which the board has half a metre
  EXPECT_TRUE(is_taken(scene.nds, target, 1.8));
  target.foot_map_m.y() = 7.5;
  EXPECT_TRUE(is_taken(scene.nds, target, 0.7));
  target.foot_map_m.z() = 10.0;  // above the wall
  EXPECT_FALSE(is_taken(scene.nds, target, 0.7));
}

TEST(GroundHeight, IsKnownWhereGroundIs) {
  const CorridorScene scene;
  const Eigen::Vector3d& p_m = scene.views.front().p_map_m;
  EXPECT_NEAR(*ground_height_m(scene.nds, {40.0, 5.0}, p_m), kCorridorGround_m, 1e-6);
  EXPECT_FALSE(ground_height_m(scene.nds, {40.0, 40.0}, p_m));
}

// Faces along the street, 8 m ahead of the middle site and 4 m beside it.
Target board(const CorridorScene& scene) {
  Target target;
  target.foot_map_m = scene.views.front().p_map_m + Eigen::Vector3d(8.0, 4.0, -1.9);
  target.size = {1.5, 2.0, 0.5};
  return target;
}

std::vector<Eigen::Vector3d> points_of(const CorridorScene& scene,
                                       const std::vector<double>& distance_m) {
  std::vector<Eigen::Vector3d> points_m;
  for (std::size_t i = 0; i < distance_m.size(); ++i) {
    if (std::isfinite(distance_m[i])) points_m.emplace_back(distance_m[i] * scene.directions[i]);
  }
  return points_m;
}

Matrix6d information_of(const CorridorScene& scene, const std::vector<double>& distance_m,
                        const NdtMap& map) {
  const std::vector<Eigen::Vector3d> thinned_m =
      voxel_subsample(points_of(scene, distance_m), scene.options.leaf_m);
  return scan_information(scene.views.front().p_map_m, thinned_m, map, make_match_grid(map),
                          {scene.options.range_m})[0]
      .pose;
}

void expect_near(const Matrix6d& found, const Matrix6d& expected) {
  EXPECT_LT((found - expected).norm(), 1e-9 * expected.norm());
}

TEST(SiteView, HoldsTheInformationOfItsThinnedScan) {
  const CorridorScene scene;
  expect_near(scene.views.front().information,
              information_of(scene, scene.views.front().distance_m, scene.map));
}

TEST(TargetGain, MeetsABoardByHand) {
  Target target;
  target.foot_map_m = {10.0, 0.0, 0.0};
  const Eigen::Vector3d p_m(0.0, 0.0, 1.5);
  EXPECT_DOUBLE_EQ(*distance_to_target_m(target, p_m, {1.0, 0.0, 0.0}), 10.0);
  // 0.51 m aside at 10 m; above 2.5 m; below 0.5 m; behind; along the board.
  EXPECT_FALSE(distance_to_target_m(target, p_m, Eigen::Vector3d(10.0, 0.51, 0.0).normalized()));
  EXPECT_FALSE(distance_to_target_m(target, p_m, Eigen::Vector3d(10.0, 0.0, 1.01).normalized()));
  EXPECT_FALSE(distance_to_target_m(target, p_m, Eigen::Vector3d(10.0, 0.0, -1.01).normalized()));
  EXPECT_FALSE(distance_to_target_m(target, p_m, {-1.0, 0.0, 0.0}));
  EXPECT_FALSE(distance_to_target_m(target, p_m, {0.0, 1.0, 0.0}));
  target.facing = {-1.0, 0.0};
  EXPECT_DOUBLE_EQ(*distance_to_target_m(target, p_m, {1.0, 0.0, 0.0}), 10.0);
}

TEST(TargetGain, IsThatOfEverythingDoneAnew) {
  const CorridorScene scene;
  const SiteView& view = scene.views.front();
  const Target target = board(scene);
  const std::vector<TargetHit> hits = hits_of(target, view, scene.directions, 50.0);
  ASSERT_GT(hits.size(), 50U);
  std::vector<double> distance_m = view.distance_m;
  for (std::size_t beam = 0; beam < distance_m.size(); ++beam) {
    const std::optional<double> hit_m =
        distance_to_target_m(target, view.p_map_m, scene.directions[beam]);
    if (hit_m && *hit_m < distance_m[beam]) distance_m[beam] = *hit_m;
  }
  // Each hit stands for three scans of the map.
  std::map<CellKey, CellMoments> cells;
  for (const TargetHit& hit : hits) {
    const Eigen::Vector3d at_m = view.p_map_m + hit.distance_m * scene.directions[hit.beam];
    const CellKey key = cell_key(at_m, 2.0);
    for (int scan = 0; scan < 3; ++scan) cells[key].add(at_m - cell_centre_m(key, 2.0));
    cells[key].products_m2 += 3.0 * 0.0008 * Eigen::Matrix3d::Identity();
  }
  NdtMap map = scene.map;
  std::size_t merged = 0;
  for (Nd& nd : map.nds) {
    if (!cells.contains(nd.key)) continue;
    CellMoments cell = cells[nd.key];
    cell.add(nd, nd.mean_m - cell_centre_m(nd.key, 2.0));
    nd = nd_of(nd.key, cell, 2.0);
    cells.erase(nd.key);
    ++merged;
  }
  EXPECT_GT(merged, 0U);
  std::size_t added = 0;
  for (const auto& [key, cell] : cells) {
    if (cell.count < 10.0) continue;
    map.nds.push_back(nd_of(key, cell, 2.0));
    ++added;
  }
  EXPECT_GT(added, 0U);
  const ChangedNds changed = nds_with_target(scene.nds, {{view, hits, 3.0}}, scene.directions);
  EXPECT_EQ(changed.size(), merged + added);
  const Matrix6d found = information_with_target(
      view, hits, {scene.nds, changed, scene.directions, scene.options.leaf_m});
  expect_near(found, information_of(scene, distance_m, map));
  // And it holds the street's direction better.
  EXPECT_LT(std_along_m(crlb(found), 0.0), 0.9 * std_along_m(crlb(view.information), 0.0));
}

TEST(TargetGain, OfABoardThatNothingSeesIsNone) {
  const CorridorScene scene;
  Target hidden = board(scene);
  hidden.foot_map_m.y() += 10.0;  // behind the wall
  EXPECT_TRUE(hits_of(hidden, scene.views.front(), scene.directions, 50.0).empty());
  Target far = board(scene);
  EXPECT_TRUE(hits_of(far, scene.views.front(), scene.directions, 5.0).empty());
  const Matrix6d found =
      information_with_target(scene.views.front(), {}, {scene.nds, {}, scene.directions, 1.0});
  EXPECT_EQ(found, scene.views.front().information);
}

TEST(TargetGain, IsThatOfBeamsInView) {
  CorridorScene scene;
  const Target target = board(scene);
  const std::vector<TargetHit> round = hits_of(target, scene.views.front(), scene.directions, 50.0);
  SensorProfile sensor = corridor_sensor();
  sensor.azimuth_view_deg = 70.4;
  scene.options.view = AzimuthView(sensor);
  const Eigen::Vector3d to_board_m = target.foot_map_m - scene.views.front().p_map_m;
  const double ahead_rad = std::atan2(to_board_m.y(), to_board_m.x());
  const auto hits_facing = [&](double yaw_rad) {
    scene.sites.sites[2].T_map_vehicle.linear() =
        Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const std::vector<SiteView> seen = value_of(
        views_from(scene.ctx, scene.options, scene.nds, scene.sites, {2}, scene.directions));
    return hits_of(target, seen.front(), scene.directions, 50.0).size();
  };
  EXPECT_EQ(hits_facing(ahead_rad), round.size());
  EXPECT_EQ(hits_facing(ahead_rad + std::numbers::pi), 0U);
}

}  // namespace
}  // namespace sightline

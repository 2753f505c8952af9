#include "passes/weakness/advise_targets.h"

#include <gtest/gtest.h>

#include <cmath>

#include "passes/factors/virtual/crlb.h"
#include "tests/passes/weakness/corridor.h"

namespace sightline {
namespace {

std::vector<TargetAdvice> advice_of(const CorridorScene& scene, const AdviceOptions& options,
                                    int threads = 1) {
  PassContext ctx;
  ctx.threads = threads;
  const std::vector<double> weights = {30.0};
  const std::vector<double> std_m = {std_along_m(crlb(scene.views[0].information), 0.0)};
  return advise_targets(ctx, options,
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
  const double held = advice_of(CorridorScene(true), {}).front().gain;
  EXPECT_LT(held, 0.8 * bare);
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

}  // namespace
}  // namespace sightline

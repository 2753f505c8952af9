#include "passes/matching/look_test.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "passes/matching/localizer.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

// A match whose score has these curvatures along x and y, and 100 of everything else.
MatchResult match_with(double along_x_per_m2, double along_y_per_m2) {
  MatchResult match;
  match.hessian.diagonal() << along_x_per_m2, along_y_per_m2, 100.0, 100.0, 100.0, 100.0;
  match.scored_points = 60;
  match.score = 300.0;
  match.nearest_voxel_likelihood = 3.0;
  return match;
}

TEST(LookTest, ReadsEightNumbersOffAMatch) {
  MatchResult match = match_with(400.0, 25.0);  // y is the loose direction: 0.2 m
  match.T_map_sensor.translation() = Eigen::Vector3d(0.03, -0.4, 0.04);
  match.T_map_sensor.linear() =
      Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const LookSigns signs = look_signs(match, 80, Pose::Identity());
  EXPECT_NEAR(signs[0], std::log(0.2), 1e-5);
  EXPECT_NEAR(signs[1], std::log(0.05), 1e-5);
  EXPECT_DOUBLE_EQ(signs[2], 0.75);
  EXPECT_DOUBLE_EQ(signs[3], 5.0);
  EXPECT_DOUBLE_EQ(signs[4], 3.0);
  EXPECT_NEAR(signs[5], std::log(0.41), 1e-9);
  EXPECT_NEAR(signs[6], std::log(0.06), 1e-9);
  EXPECT_NEAR(signs[7], std::log(0.021), 1e-9);
}

TEST(LookTest, SignsAreFiniteForAnyMatch) {
  Random random(5);
  for (int trial = 0; trial < 200; ++trial) {
    MatchResult match;
    for (double& value : match.hessian.reshaped()) value = random.uniform(-1e6, 1e6);
    match.hessian = (0.5 * (match.hessian + match.hessian.transpose())).eval();
    if (trial % 3 == 0) match.hessian.setZero();
    match.scored_points = static_cast<std::uint32_t>(random.below(3));
    match.T_map_sensor = random_pose(random, 100.0, 3.0);
    for (const double sign : look_signs(match, random.below(3), random_pose(random, 1.0, 3.0))) {
      EXPECT_TRUE(std::isfinite(sign));
    }
  }
  for (const double sign : look_signs({}, 0, Pose::Identity())) EXPECT_TRUE(std::isfinite(sign));
}

TEST(LookTest, SignsDoNotDependOnWhereInTheMapTheVehicleIs) {
  Random random(6);
  MatchResult match = match_with(400.0, 25.0);
  const Pose T_map_predicted = random_pose(random, 0.1, 0.1);
  const LookSigns here = look_signs(match, 80, T_map_predicted);
  Pose there = T_map_predicted;
  there.translation() += Eigen::Vector3d(512.0, 256.0, 0.0);
  match.T_map_sensor.translation() += Eigen::Vector3d(512.0, 256.0, 0.0);
  const LookSigns elsewhere = look_signs(match, 80, there);
  for (std::size_t i = 0; i < kLookSigns; ++i) EXPECT_NEAR(elsewhere[i], here[i], 1e-9);
}

}  // namespace
}  // namespace sightline

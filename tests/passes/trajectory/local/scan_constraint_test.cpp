#include "passes/trajectory/local/scan_constraint.h"

#include <gtest/gtest.h>
#include <cmath>
#include <utility>
#include <vector>

#include "formats/base/random.h"
#include "passes/trajectory/local/local_match.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

// The constraint of a scan by a local map of the scans before it, 1 m apart along x; returns with 1
// cm of noise.
ScanConstraint constraint_in(const BoxWorld& world, std::size_t scans_before = 12) {
  Random random(7);
  std::vector<Pose> poses;
  for (std::size_t i = 0; i <= scans_before; ++i) {
    poses.push_back(pose_at(static_cast<double>(i), 0.3, 0.02));
  }
  TestDrive test = drive_through(world, poses, 0.5);
  add_noise(0.01, random, test);
  std::vector<Eigen::Vector3d> map_m;
  for (std::size_t k = 0; k < scans_before; ++k) {
    const Pose T_map_lidar = poses[k] * test.drive.sensor.T_vehicle_lidar;
    const auto before = read_thinned(test.drive, k);
    for (const Eigen::Vector3d& point_m : before->to_map_m) {
      map_m.push_back(T_map_lidar * point_m);
    }
  }
  return scan_constraint(met_surfaces(local_grids(map_m),
                                      read_thinned(test.drive, scans_before)->to_match_m,
                                      poses.back() * test.drive.sensor.T_vehicle_lidar,
                                      test.drive.sensor.T_vehicle_lidar.inverse()));
}

BoxWorld with(BoxWorld world, const std::vector<TestBox>& boxes) {
  world.boxes.insert(world.boxes.end(), boxes.begin(), boxes.end());
  return world;
}

TEST(ScanConstraint, AlongBareWallsIsWeakAlongThemAlone) {
  const ScanConstraint found = constraint_in(bare_street());
  EXPECT_GT(found.sigma_m[0], kWeak_m);
  EXPECT_LT(found.sigma_m[1], kWeakBesideGiven_m);
  EXPECT_GT(found.sigma_m[0], 1.0);
  EXPECT_LT(found.sigma_m[1], 0.01);
  // The vehicle's heading is 0.02 rad from the walls.
  EXPECT_NEAR(std::abs(found.motions(0, 0)), 1.0, 1e-3);
  EXPECT_NEAR(std::abs(found.motions(1, 0)), 0.02, 0.01);
  EXPECT_NEAR(found.weak_axes(kWeak_m)[0], 1.0, 1e-3);
  const PlanarMotion part = found.weak_part(kWeak_m) * PlanarMotion{2.0, 1.0, 0.5};
  EXPECT_NEAR(part[0], 2.0, 0.05);
  EXPECT_NEAR(part[1], 0.0, 0.06);
}

TEST(ScanConstraint, OnBareGroundIsWeakInEveryMotion) {
  const ScanConstraint found = constraint_in({});
  for (int i = 0; i < 3; ++i) EXPECT_GT(found.sigma_m[i], kWeak_m) << i;
  const PlanarMotion motion(0.3, -0.2, 0.1);
  EXPECT_LT((found.weak_part(kWeak_m) * motion - motion).norm(), 1e-12);
}

TEST(ScanConstraint, OfAWallAcrossTheEndIsComplete) {
  const std::vector<TestBox> end = {{{30.0, -6.0, 0.0}, {31.0, 6.0, 6.0}}};
  const ScanConstraint found = constraint_in(with(bare_street(), end));
  EXPECT_FALSE(found.has_weak(kWeak_m));
  EXPECT_TRUE(found.weak_part(kWeak_m).isZero(0.0));
}

TEST(ScanConstraint, OfPolesIsComplete) {
  std::vector<TestBox> poles;
  for (const double x_m : {-4.0, 3.3, 9.4, 15.7, 22.2}) {
    poles.push_back({{x_m, 4.3, 0.0}, {x_m + 0.2, 4.5, 6.0}});
    poles.push_back({{x_m + 2.0, -4.5, 0.0}, {x_m + 2.2, -4.3, 6.0}});
  }
  EXPECT_FALSE(constraint_in(with({}, poles)).has_weak(kWeak_m));
  EXPECT_FALSE(constraint_in(with(bare_street(), poles)).has_weak(kWeak_m));
}

TEST(ScanConstraint, OfAStreetIsComplete) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const ScanConstraint found = constraint_in(random_street(seed));
    EXPECT_FALSE(found.has_weak(kWeak_m)) << seed << ": " << found.sigma_m.transpose();
  }
}

TEST(KeptShares, AreOneWithoutConstraintAndAHalfAtTheErrorOfTheStart) {
  ScanConstraint constraint;
  constraint.sigma_m = {100.0, 0.3, 0.003};
  Eigen::Vector3d kept = kept_shares(constraint);
  EXPECT_NEAR(kept[0], 1.0, 1e-5);
  EXPECT_NEAR(kept[1], 0.5, 1e-9);
  EXPECT_NEAR(kept[2], 1e-4, 1e-6);
  constraint.sigma_m[0] = 0.1;
  EXPECT_NEAR(kept_shares(constraint)[0], 0.5, 1e-9);
  // A weak motion between two axes leaves half of an error along each.
  constraint.sigma_m = {100.0, 0.0, 0.0};
  constraint.motions.col(0) = Eigen::Vector3d(1.0, 1.0, 0.0).normalized();
  constraint.motions.col(1) = Eigen::Vector3d(-1.0, 1.0, 0.0).normalized();
  kept = kept_shares(constraint);
  EXPECT_NEAR(kept[0], 0.5, 1e-5);
  EXPECT_NEAR(kept[1], 0.5, 1e-5);
  EXPECT_EQ(kept[2], 0.0);
}

TEST(PlanarMotion, LeadsFromOnePoseToTheOther) {
  const Pose from = pose_at(3.0, -2.0, 0.7);
  const PlanarMotion motion(1.5, -0.4, 0.8);
  const Pose to = moved_in_plane(from, motion);
  EXPECT_LT((planar_motion(from, to) - motion).norm(), 1e-12);
  const Pose turned = pose_at(3.0, -2.0, 0.7 + 0.8 / kTurnArm_m);
  EXPECT_LT((to.linear() - turned.linear()).norm(), 1e-12);
  EXPECT_NEAR((to.translation() - from.translation()).norm(), std::hypot(1.5, 0.4), 1e-12);
}

}  // namespace
}  // namespace sightline

#include "passes/map/choose_sites.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

struct Journey {
  Drive drive;
  Trajectory trajectory;

  void add(const Pose& T_map_vehicle) {
    const auto index = static_cast<std::uint32_t>(drive.scans.size());
    ScanInfo scan;
    scan.recording_index = index;
    scan.stamp_ns = index;
    drive.scans.push_back(scan);
    trajectory.poses.push_back({index, index, T_map_vehicle});
  }
  void add(double x_m, double y_m, double z_m) { add(Pose(Eigen::Translation3d(x_m, y_m, z_m))); }
};

Pose random_pose(Random& random, double reach_m) {
  const Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
  Pose pose = Pose::Identity();
  pose.linear() =
      Eigen::AngleAxisd(random.uniform(-3.0, 3.0), axis.normalized()).toRotationMatrix();
  for (int i = 0; i < 3; ++i) pose.translation()[i] = random.uniform(-reach_m, reach_m);
  return pose;
}

Journey random_journey(std::uint64_t seed) {
  Random random(seed);
  Journey journey;
  Pose pose = random_pose(random, 100.0);
  for (int i = 0; i < 60; ++i) {
    journey.add(pose);
    Pose step = pose_at(0.0, 0.0, random.uniform(-0.3, 0.3));
    step.translation().x() = random.uniform();
    if (random.below(20) == 0) step.translation().x() = 20.0;
    pose = pose * step;
  }
  journey.drive.sensor.T_vehicle_lidar = random_pose(random, 2.0);
  return journey;
}

Sites sites_of(const Journey& journey, const ChooseSitesOptions& options = {}) {
  return value_of(choose_sites(TestContext(), options, journey.drive, journey.trajectory));
}

TEST(ChooseSites, LieEveryMetreOfAnLShapedRoute) {
  Journey journey;
  journey.drive.sensor.T_vehicle_lidar.translation().z() = 1.8;
  journey.add(0.0, 0.0, 0.0);
  journey.add(1.5, 0.0, 0.0);
  journey.add(1.5, 0.0, 2.0);  // straight up: arc length is 3D
  const Sites sites = sites_of(journey);
  ASSERT_EQ(sites.sites.size(), 4u);
  EXPECT_EQ(sites.sites[1].T_map_vehicle.translation(), Eigen::Vector3d(1.0, 0.0, 0.0));
  EXPECT_EQ(sites.sites[2].T_map_vehicle.translation(), Eigen::Vector3d(1.5, 0.0, 0.5));
  EXPECT_EQ(sites.sites[3].T_map_vehicle.translation(), Eigen::Vector3d(1.5, 0.0, 1.5));
  EXPECT_EQ(sites.sites[3].p_map_m, Eigen::Vector3d(1.5, 0.0, 3.3));
  EXPECT_EQ(sites.sites[3].s_m, 3.0);
}

TEST(ChooseSites, TurnHalfWayBetweenTwoPoses) {
  Journey journey;
  journey.add(0.0, 0.0, 0.0);
  journey.add(pose_at(2.0, 0.0, 1.0));
  const Sites sites = sites_of(journey);
  ASSERT_EQ(sites.sites.size(), 3u);
  const Eigen::AngleAxisd half(sites.sites[1].T_map_vehicle.linear());
  EXPECT_NEAR(half.angle(), 0.5, 1e-12);
}

TEST(ChooseSites, IgnoreAVehicleThatStands) {
  Journey moving;
  Journey waiting;
  for (int i = 0; i < 5; ++i) {
    moving.add(i, 0.0, 0.0);
    waiting.add(i, 0.0, 0.0);
    for (int k = 0; k < 10; ++k) waiting.add(i, 0.05 * (k % 2), 0.0);
  }
  const Sites a = sites_of(moving);
  const Sites b = sites_of(waiting);
  ASSERT_EQ(a.sites.size(), 5u);
  ASSERT_EQ(b.sites.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(a.sites[i].p_map_m, b.sites[i].p_map_m);
}

TEST(ChooseSites, StartANewRunAfterAGap) {
  Journey journey;
  journey.add(0.0, 0.0, 0.0);
  journey.add(1.2, 0.0, 0.0);
  journey.add(6.2, 0.0, 0.0);   // 5 m: not over the limit
  journey.add(11.3, 0.0, 0.0);  // 5.1 m: a gap
  journey.add(12.3, 0.0, 0.0);
  const Sites sites = sites_of(journey);
  ASSERT_EQ(sites.sites.size(), 7u + 2u);
  EXPECT_EQ(sites.sites[6].run, 0u);
  EXPECT_EQ(sites.sites[7].run, 1u);
  EXPECT_EQ(sites.sites[7].s_m, 0.0);
  EXPECT_EQ(sites.sites[8].p_map_m, Eigen::Vector3d(12.3, 0.0, 0.0));
  EXPECT_TRUE(validate(sites).has_value());
}

TEST(ChooseSites, UseTheScansThatAreAskedFor) {
  Journey journey;
  for (int i = 0; i < 6; ++i) journey.add(i, i % 2 == 0 ? 0.0 : 3.0, 0.0);
  ChooseSitesOptions options{.scans = ScanSelection::kEven};
  for (const Site& site : sites_of(journey, options).sites) EXPECT_EQ(site.p_map_m.y(), 0.0);
  options.scans = ScanSelection::kOdd;
  for (const Site& site : sites_of(journey, options).sites) EXPECT_EQ(site.p_map_m.y(), 3.0);
}

void drive_along(Journey& journey, double from_m, double to_m, double y_m, std::uint32_t part) {
  const double heading_rad = to_m < from_m ? 3.141592653589793 : 0.0;
  const int count = static_cast<int>(std::abs(to_m - from_m)) + 1;
  for (int i = 0; i < count; ++i) {
    journey.add(pose_at(to_m < from_m ? from_m - i : from_m + i, y_m, heading_rad));
    journey.drive.scans.back().part = part;
  }
}

TEST(ChooseSites, LieOnceWhereSeveralDrivesPassInOneDirection) {
  Journey journey;
  drive_along(journey, 0.0, 30.0, 0.0, 0);
  drive_along(journey, 10.0, 50.0, 1.0, 1);  // new from 33 m on
  drive_along(journey, 0.0, 30.0, 0.5, 2);   // nothing new
  drive_along(journey, 30.0, 0.0, 0.0, 3);   // the other way
  drive_along(journey, 0.0, 30.0, -3.5, 4);  // the next lane
  const Sites sites = sites_of(journey);
  std::vector<int> count(5, 0);
  for (const Site& site : sites.sites) {
    const Eigen::Vector3d p_m = site.p_map_m;
    const bool goes_back = site.T_map_vehicle.linear()(0, 0) < 0.0;
    ++count[goes_back ? 3 : p_m.y() < -3.0 ? 4 : p_m.x() > 30.5 ? 1 : 0];
  }
  EXPECT_EQ(count, (std::vector<int>{31, 18, 0, 31, 31}));
  EXPECT_TRUE(validate(sites).has_value());
}

TEST(ChooseSites, LieOnceWhereOneDriveComesBack) {
  Journey journey;
  const double radius_m = 15.0;  // 94 m around
  for (int i = 0; i < 160; ++i) {
    const double angle_rad = i / radius_m;
    journey.add(
        pose_at(radius_m * std::sin(angle_rad), radius_m * (1.0 - std::cos(angle_rad)), angle_rad));
  }
  const Sites sites = sites_of(journey);
  EXPECT_NEAR(static_cast<double>(sites.sites.size()), 93.0, 2.0);
  EXPECT_EQ(sites.sites.back().run, 0U);
}

// Rounds of a circle, of which the last quarter of each rises.
Journey drive_up(int rounds, double radius_m, double rise_m) {
  Journey journey;
  const int steps = static_cast<int>(2.0 * std::numbers::pi * radius_m);
  for (int i = 0; i <= rounds * steps; ++i) {
    const double rounds_done = static_cast<double>(i) / steps;
    const double angle_rad = 2.0 * std::numbers::pi * rounds_done;
    const double storey = std::floor(rounds_done);
    const double ramp = std::clamp(4.0 * (rounds_done - storey) - 3.0, 0.0, 1.0);
    Pose pose =
        pose_at(radius_m * std::sin(angle_rad), radius_m * (1.0 - std::cos(angle_rad)), angle_rad);
    pose.translation().z() = rise_m * (storey + ramp);
    journey.add(pose);
  }
  return journey;
}

TEST(ChooseSites, LieOnEveryStoreyOfACarPark) {
  for (const double rise_m : {2.2, 2.75, 5.0}) {
    const Journey journey = drive_up(3, 15.0, rise_m);
    const Sites sites = sites_of(journey);
    EXPECT_EQ(sites.sites.back().run, 0U);
    for (const TrajectoryPose& pose : journey.trajectory.poses) {
      double nearest_m = 1e9;
      for (const Site& site : sites.sites) {
        nearest_m = std::min(nearest_m, (site.p_map_m - pose.T_map_vehicle.translation()).norm());
      }
      ASSERT_LT(nearest_m, 1.0) << rise_m << " m, height " << pose.T_map_vehicle.translation().z();
    }
  }
}

TEST(ChooseSites, LieOnceWhereTheHeightOfASecondRoundIsALittleOff) {
  const auto count = [](double off_m) { return sites_of(drive_up(2, 15.0, off_m)).sites.size(); };
  EXPECT_NEAR(static_cast<double>(count(0.9)), 93.0, 2.0);
  EXPECT_GT(count(1.5), 150U);
}

TEST(ChooseSites, LeaveNoPlaceWithoutASiteNearby) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    Journey journey;
    for (std::uint32_t part = 0; part < 5; ++part) {
      drive_along(journey, random.uniform(0.0, 40.0), random.uniform(50.0, 90.0),
                  random.uniform(-4.0, 4.0), part);
    }
    const Sites sites = sites_of(journey);
    for (const TrajectoryPose& pose : journey.trajectory.poses) {
      double nearest_m = 1e9;
      for (const Site& site : sites.sites) {
        nearest_m =
            std::min(nearest_m, (site.p_map_m - pose.T_map_vehicle.translation()).head<2>().norm());
      }
      ASSERT_LT(nearest_m, 3.0) << "seed " << seed;
    }
  }
}

// The position at arc length s along the polyline through `corners`.
Eigen::Vector3d walk(const std::vector<Eigen::Vector3d>& corners, double s_m) {
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const double step_m = (corners[i] - corners[i - 1]).norm();
    if (s_m <= step_m) return corners[i - 1] + (s_m / step_m) * (corners[i] - corners[i - 1]);
    s_m -= step_m;
  }
  return corners.back();
}

TEST(ChooseSites, AreEquallySpacedAlongAnyRoute) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const Journey journey = random_journey(seed);
    const ChooseSitesOptions options{.spacing_m = seed % 2 == 0 ? 1.0 : 0.7};
    const Sites sites = sites_of(journey, options);
    ASSERT_TRUE(validate(sites).has_value());
    // The runs again, by the words of the definition.
    std::vector<std::vector<Eigen::Vector3d>> runs;
    for (const TrajectoryPose& pose : journey.trajectory.poses) {
      const Eigen::Vector3d here = pose.T_map_vehicle.translation();
      if (!runs.empty() && (here - runs.back().back()).norm() < 0.1) continue;
      if (runs.empty() || (here - runs.back().back()).norm() > 5.0) runs.emplace_back();
      runs.back().push_back(here);
    }
    ASSERT_EQ(sites.sites.back().run + 1, runs.size());
    std::size_t k = 0;
    for (std::size_t i = 0; i < sites.sites.size(); ++i) {
      const Site& site = sites.sites[i];
      k = i > 0 && site.run == sites.sites[i - 1].run ? k + 1 : 0;
      ASSERT_EQ(site.s_m, static_cast<double>(k) * options.spacing_m);
      ASSERT_LT((site.T_map_vehicle.translation() - walk(runs[site.run], site.s_m)).norm(), 1e-9);
      ASSERT_LT(
          (site.T_map_vehicle * journey.drive.sensor.T_vehicle_lidar.translation() - site.p_map_m)
              .norm(),
          1e-9);
    }
  }
}

// Keyframes are 5 to 10 m apart.
TEST(ChooseSites, GoOnBetweenPosesAsFarApartAsIsUsualThere) {
  for (const double step_m : {1.0, 4.0, 6.0, 12.0, 16.0}) {
    Journey journey;
    for (int i = 0; i < 20; ++i) journey.add(step_m * i, 0.0, 0.0);
    TestContext ctx;
    const Sites sites = value_of(choose_sites(ctx, {}, journey.drive, journey.trajectory));
    const bool has_gaps = step_m > 15.0;
    EXPECT_EQ(sites.sites.back().run, has_gaps ? 19U : 0U) << step_m;
    ASSERT_EQ(ctx.warnings.size(), has_gaps ? 1U : 0U) << step_m;
    for (const std::string& warning : ctx.warnings) {
      EXPECT_NE(warning.find("choose-sites.largest_gap_m"), std::string::npos);
    }
  }
}

// Where poses are a metre apart, a step of 6 m is a gap.
TEST(ChooseSites, EndAtAGapInADenseDrive) {
  Journey journey;
  for (int i = 0; i < 20; ++i) journey.add(i < 10 ? i : i + 5.0, 0.0, 0.0);
  EXPECT_EQ(sites_of(journey).sites.back().run, 1U);
}

TEST(ChooseSites, BeginANewRunAtEveryPieceOfTheTrajectory) {
  Journey journey = random_journey(3);
  const std::uint32_t runs = sites_of(journey).sites.back().run;
  const std::size_t count = journey.trajectory.poses.size();
  for (std::size_t i = count / 2; i < count; ++i) journey.trajectory.poses[i].piece = 1;
  const ChooseSitesOptions options{.largest_gap_m = 1000.0};
  EXPECT_EQ(sites_of(journey, options).sites.back().run, 1u);
  EXPECT_GE(sites_of(journey).sites.back().run, runs);
}

TEST(ChooseSites, MoveWithTheWorld) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Journey journey = random_journey(seed);
    Random random(mix(seed, 7));
    const Pose T_other_map = random_pose(random, 1000.0);
    Journey moved = journey;
    for (TrajectoryPose& pose : moved.trajectory.poses) {
      pose.T_map_vehicle = T_other_map * pose.T_map_vehicle;
    }
    const Sites here = sites_of(journey);
    const Sites there = sites_of(moved);
    ASSERT_EQ(here.sites.size(), there.sites.size());
    for (std::size_t i = 0; i < here.sites.size(); ++i) {
      const Pose expected = T_other_map * here.sites[i].T_map_vehicle;
      ASSERT_TRUE(there.sites[i].T_map_vehicle.isApprox(expected, 1e-9));
    }
  }
}

TEST(ChooseSites, RefuseATrajectoryOfAnotherDrive) {
  Journey journey;
  journey.add(0.0, 0.0, 0.0);
  journey.add(1.0, 0.0, 0.0);
  PassContext ctx;
  Trajectory shorter = journey.trajectory;
  shorter.poses.pop_back();
  EXPECT_EQ(failure_of(choose_sites(ctx, {}, journey.drive, shorter)).code,
            ErrorCode::kMismatchedInputs);
  Trajectory other = journey.trajectory;
  other.poses[1].recording_index = 5;
  EXPECT_EQ(failure_of(choose_sites(ctx, {}, journey.drive, other)).place, "pose 1");
}

TEST(ChooseSites, RefuseADriveWithoutTheScansAskedFor) {
  Journey journey;
  journey.add(0.0, 0.0, 0.0);
  const ChooseSitesOptions options{.scans = ScanSelection::kOdd};
  EXPECT_EQ(
      failure_of(choose_sites(TestContext(), options, journey.drive, journey.trajectory)).code,
      ErrorCode::kDriveTooShort);
}

}  // namespace
}  // namespace sightline

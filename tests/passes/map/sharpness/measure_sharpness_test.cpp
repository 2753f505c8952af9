#include "passes/map/sharpness/measure_sharpness.h"

#include <gtest/gtest.h>
#include <cmath>

#include "tests/support/artifact_checks.h"
#include "tests/support/box_world.h"
#include "tests/support/kept_parts.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

// A level square of points every 0.1 m, at heights that alternate like a chessboard's fields.
std::vector<Eigen::Vector3d> chessboard(double step_m) {
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 80; ++i) {
    for (int j = 0; j < 80; ++j) {
      points_m.emplace_back(0.05 + 0.1 * i, 0.05 + 0.1 * j, 0.5 + ((i + j) % 2) * step_m);
    }
  }
  return points_m;
}

// Half of the points 0.1 m below the mean, half above: 0.01 m2 across, times n / (n - 1) of the 400
// points in a cell.
TEST(MeasureSharpness, SaysHowThickAPlaneIs) {
  const SharpnessFigures flat = sharpness_of(chessboard(0.0), {}, 1);
  EXPECT_NEAR(flat.mean_plane_variance_m2, 0.0, 1e-15);
  EXPECT_EQ(flat.plane_points, 6400u);
  const SharpnessFigures thick = sharpness_of(chessboard(0.2), {}, 1);
  EXPECT_NEAR(thick.mean_plane_variance_m2, 0.01 * 400.0 / 399.0, 1e-12);
  EXPECT_LT(flat.mean_entropy_nat, thick.mean_entropy_nat - 1.0);
}

// Points on the axes at +-a and at the middle, many times over: Sigma = 2/7 a^2 I times n / (n -
// 1).
TEST(MeasureSharpness, GivesTheEntropyOfADistributionThatIsKnown) {
  constexpr double kAway_m = 0.3;
  std::vector<Eigen::Vector3d> points_m;
  for (int copy = 0; copy < 16; ++copy) {
    points_m.emplace_back(0.0, 0.0, 0.0);
    for (int axis = 0; axis < 3; ++axis) {
      points_m.push_back(kAway_m * Eigen::Vector3d::Unit(axis));
      points_m.push_back(-kAway_m * Eigen::Vector3d::Unit(axis));
    }
  }
  MeasureSharpnessOptions options;
  options.radius_m = 0.7;  // every point sees every other
  const SharpnessFigures found = sharpness_of(points_m, options, 1);
  const double n = 7.0 * 16.0;
  const double variance_m2 = 2.0 * 16.0 * kAway_m * kAway_m / (n - 1.0) + 1e-6;
  const double expected_nat =
      1.5 * std::log(2.0 * std::numbers::pi * std::numbers::e * variance_m2);
  EXPECT_NEAR(found.mean_entropy_nat, expected_nat, 1e-9);
  EXPECT_EQ(found.entropy_points, 7u);
}

std::vector<Eigen::Vector3d> house(Random& random, double yaw_rad) {
  const Pose T_map_house = pose_at(0.0, 0.0, yaw_rad);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 120; ++i) {
    for (int j = 0; j < 30; ++j) {
      for (const double y_m : {12.0, 20.0}) {
        points_m.push_back(T_map_house *
                           Eigen::Vector3d(0.1 * i, y_m + 0.02 * random.normal(), 0.1 * j));
      }
    }
  }
  return points_m;
}

// As where a quick turn of the hand was not seen: entropy hardly shows it, planes do.
TEST(MeasureSharpness, TellsAHouseThatIsLaidTwiceByItsPlanes) {
  Random random(3);
  std::vector<Eigen::Vector3d> once_m = house(random, 0.0);
  std::vector<Eigen::Vector3d> twice_m = once_m;
  for (const Eigen::Vector3d& point_m : house(random, 0.0)) once_m.push_back(point_m);
  for (const Eigen::Vector3d& point_m : house(random, 0.52)) twice_m.push_back(point_m);
  const SharpnessFigures once = sharpness_of(once_m, {}, 1);
  EXPECT_GT(sharpness_of(twice_m, {}, 1).mean_plane_variance_m2, 2.0 * once.mean_plane_variance_m2);
}

TestDrive street(std::uint64_t seed) {
  std::vector<Pose> poses;
  for (int i = 0; i < 5; ++i) poses.push_back(pose_at(2.1 * i, 0.1 * i, 0.02 * i));
  return drive_through(random_street(seed), poses);
}

TEST(MeasureSharpness, SeesThatWrongPosesSmearTheMap) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    TestDrive test = street(seed);
    Random random(seed);
    for (std::size_t i = 0; i < test.drive.scans.size(); ++i) {
      Pose given = test.truth.poses[i].T_map_vehicle;
      for (int axis = 0; axis < 3; ++axis) given.translation()[axis] += 0.1 * random.normal();
      test.drive.scans[i].T_world_vehicle = given;
    }
    test.truth.source = PoseSource::kEstimated;
    const Sharpness found = value_of(measure_sharpness(TestContext(), {}, test.drive, test.truth));
    ASSERT_TRUE(found.of_given.has_value());
    EXPECT_GT(found.of_given->mean_entropy_nat, found.of_map.mean_entropy_nat) << seed;
    expect_survives_disk(found);
  }
}

TEST(MeasureSharpness, DoesNotDependOnThreads) {
  const TestDrive test = street(9);
  const Sharpness one = value_of(measure_sharpness(TestContext(1), {}, test.drive, test.truth));
  EXPECT_EQ(one, value_of(measure_sharpness(TestContext(3), {}, test.drive, test.truth)));
}

TEST(MeasureSharpness, MakesOnlyTheTilesAnewThatAChangeReaches) {
  std::vector<Pose> poses;
  for (int i = 0; i < 12; ++i) poses.push_back(pose_at(30.0 * i, 0.0, 0.0));
  TestDrive test = drive_through(random_street(4), poses);
  KeptParts kept;
  const auto run = [&] {
    PassContext ctx = kept.context();
    return *measure_sharpness(ctx, {}, test.drive, test.truth);
  };
  (void)run();
  const std::size_t all = kept.made().size();
  EXPECT_EQ(all, kept.count());
  (void)run();
  EXPECT_EQ(kept.made().size(), 0U);
  test.truth.poses.back().T_map_vehicle.translation().y() += 0.01;
  const Sharpness after = run();
  EXPECT_GT(kept.made().size(), 0U);
  EXPECT_LT(kept.made().size(), all / 2);
  EXPECT_EQ(after, *measure_sharpness(TestContext(), {}, test.drive, test.truth));
}

TEST(MeasureSharpness, RefusesTheTrajectoryOfAnotherDrive) {
  TestDrive test = street(1);
  test.truth.poses.pop_back();
  EXPECT_EQ(failure_of(measure_sharpness(TestContext(), {}, test.drive, test.truth)).code,
            ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline

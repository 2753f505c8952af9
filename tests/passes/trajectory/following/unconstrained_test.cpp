#include "passes/trajectory/following/unconstrained.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <numbers>
#include <numeric>

#include "passes/trajectory/estimate_trajectory.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/following/steady_motion.h"
#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

using testing::HasSubstr;

// A straight way of 1 m a step; the steps to scans `first` to `last` are not constrained along it.
Odometry weak_way(std::size_t count, std::size_t first, std::size_t last, Forecast forecast) {
  Odometry odometry;
  for (std::size_t k = 0; k < count; ++k) {
    odometry.append(pose_at(static_cast<double>(k), 0.0, 0.0), k == 0 ? 0.0 : 1.0, true, {});
    if (k >= first && k <= last) {
      odometry.constraint.back() = {1.0, Eigen::Vector3d::UnitX(), forecast};
      odometry.constraint.back().kept = Eigen::Vector3d::UnitX();
    }
  }
  return odometry;
}

// Its poses, with the covariance of the forecast; the scans are every second one of a recording.
Trajectory trajectory_of(const Odometry& odometry) {
  const std::vector<Matrix6d> covariance =
      forecast_covariance(odometry, odometry.T_map_lidar, Pose::Identity());
  Trajectory trajectory;
  for (std::uint32_t k = 0; k < odometry.T_map_lidar.size(); ++k) {
    trajectory.poses.push_back({2 * k, 100 * k, odometry.T_map_lidar[k]});
    trajectory.poses.back().covariance = covariance[k];
  }
  mark_unconstrained(odometry, trajectory.poses);
  return trajectory;
}

TEST(Unconstrained, IsNamedByScansWayDirectionAndWhatWasUsed) {
  const Trajectory trajectory = trajectory_of(weak_way(80, 20, 59, Forecast::kSteady));
  const std::vector<UnconstrainedStretch> found = unconstrained_stretches(trajectory);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].first_scan, 40U);
  EXPECT_EQ(found[0].last_scan, 118U);
  EXPECT_NEAR(found[0].way_m, 40.0, 1e-9);
  EXPECT_NEAR(found[0].sigma_m.value(), std::hypot(0.7, 1.0) * 2.0, 1e-9);
  EXPECT_EQ(to_text(found[0]),
            "scans 40 to 118: 40.0 m of the way are not constrained along the road; constant speed "
            "is assumed, +/- 2.4 m");
  TestContext ctx;
  warn_of_unconstrained(ctx, "test", trajectory);
  ASSERT_EQ(ctx.warnings.size(), 1U);
  EXPECT_THAT(ctx.warnings[0], HasSubstr("scans 40 to 118"));
}

TEST(Unconstrained, BridgesShortGapsAndLeavesOutShortStretches) {
  Odometry odometry = weak_way(80, 20, 59, Forecast::kSteady);
  for (const std::size_t k : {30U, 31U, 32U}) odometry.constraint[k] = {};
  ASSERT_EQ(weak_steps(odometry).size(), 1U);
  EXPECT_NEAR(weak_steps(odometry)[0].way_m, 40.0, 1e-9);
  EXPECT_EQ(unconstrained_stretches(trajectory_of(odometry)).size(), 1U);
  EXPECT_EQ(weak_steps(weak_way(80, 20, 28, Forecast::kSteady)).size(), 0U);
  // Without a forecast the way itself may be too short.
  EXPECT_EQ(weak_steps(weak_way(80, 1, 9, Forecast::kNone)).size(), 0U);
  EXPECT_EQ(weak_steps(weak_way(80, 1, 10, Forecast::kNone)).size(), 1U);
}

// Steps that rest on a forecast for some percent are not named, nor are single scans.
TEST(Unconstrained, IsWhereMostScansOfSomeMetresLeaveAnErrorAlongAnAxis) {
  Odometry odometry = weak_way(80, 20, 59, Forecast::kSteady);
  for (StepConstraint& step : odometry.constraint) step.kept *= 0.1;
  EXPECT_TRUE(weak_steps(odometry).empty());
  for (std::size_t k = 20; k < 60; k += 3) odometry.constraint[k].kept[0] = 1.0;
  EXPECT_TRUE(weak_steps(odometry).empty());
  for (std::size_t k = 20; k < 60; k += 3) odometry.constraint[k + 1].kept[0] = 0.2;
  ASSERT_EQ(weak_steps(odometry).size(), 1U);
  EXPECT_EQ(weak_steps(odometry)[0].axis, 0);
  EXPECT_NEAR(weak_steps(odometry)[0].way_m, 40.0, 12.0) << "a median begins where most are";
  odometry = weak_way(80, 20, 59, Forecast::kSteady);
  for (std::size_t k = 40; k < 60; ++k) odometry.constraint[k].kept[1] = 0.5;
  const std::vector<UnconstrainedStretch> found = unconstrained_stretches(trajectory_of(odometry));
  ASSERT_EQ(found.size(), 2U);
  EXPECT_FALSE(found[0].directions.across);
  EXPECT_TRUE(found[1].directions.along);
  EXPECT_TRUE(found[1].directions.across);
}

// One step, which many surfaces seem to hold.
TEST(Unconstrained, IsAStepWithALeapByAsMuch) {
  Odometry odometry = weak_way(80, 1, 0, Forecast::kNone);
  odometry.constraint[40].leap_m = {-0.1, 0.7};
  const std::vector<UnconstrainedStretch> found = unconstrained_stretches(trajectory_of(odometry));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].first_scan, 80U);
  EXPECT_EQ(found[0].last_scan, 80U);
  EXPECT_TRUE(found[0].directions.across);
  EXPECT_FALSE(found[0].directions.along || found[0].directions.heading);
  EXPECT_NEAR(found[0].sigma_m.value(), 0.7, 1e-9);
  const std::vector<Matrix6d> covariance =
      forecast_covariance(odometry, odometry.T_map_lidar, Pose::Identity());
  EXPECT_EQ(covariance[39], Matrix6d::Zero());
  EXPECT_NEAR(std::sqrt(covariance[79](1, 1)), 0.7, 1e-9) << "and all poses behind it";
  EXPECT_NEAR(std::sqrt(covariance[79](0, 0)), 0.1, 1e-9);
}

TEST(Unconstrained, WhereGivenPosesLeadIsSaidWithoutAWarning) {
  const Trajectory trajectory = trajectory_of(weak_way(80, 20, 59, Forecast::kGiven));
  const std::vector<UnconstrainedStretch> found = unconstrained_stretches(trajectory);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_FALSE(found[0].is_assumed());
  EXPECT_EQ(found[0].sigma_m, std::nullopt);
  TestContext ctx;
  warn_of_unconstrained(ctx, "test", trajectory);
  EXPECT_TRUE(ctx.warnings.empty());
}

// Where the speed was wrong on one side of a curve, the end is not off along the mean of the way.
TEST(ForecastCovariance, OfASpeedIsNotAlongOneLineInACurve) {
  Odometry odometry = weak_way(420, 20, 419, Forecast::kSteady);
  for (std::size_t k = 0; k < 420; ++k) {
    const double turned_rad = 0.005 * static_cast<double>(k);
    odometry.T_map_lidar[k] =
        pose_at(std::sin(turned_rad) / 0.01, (1.0 - std::cos(turned_rad)) / 0.01, turned_rad);
  }
  const auto least_sigma_m = [&]() -> double {
    const Matrix6d last =
        forecast_covariance(odometry, odometry.T_map_lidar, Pose::Identity()).back();
    const Eigen::Matrix2d planar = last.topLeftCorner<2, 2>();
    return std::sqrt(planar.determinant() / planar.trace());
  };
  EXPECT_GT(least_sigma_m(), 1.5) << "200 m, 2 rad";
  for (StepConstraint& step : odometry.constraint) {
    step.forecast = step.forecast == Forecast::kNone ? Forecast::kNone : Forecast::kWheels;
  }
  EXPECT_LT(least_sigma_m(), 1e-6) << "of wheels the scale is wrong all along";
}

TEST(ForecastCovariance, GrowsWithTheWayAtConstantSpeedAndStays) {
  const Odometry odometry = weak_way(80, 20, 59, Forecast::kSteady);
  const std::vector<Matrix6d> found =
      forecast_covariance(odometry, odometry.T_map_lidar, Pose::Identity());
  ASSERT_EQ(found.size(), 80U);
  EXPECT_EQ(found[19], Matrix6d::Zero());
  const double unknown = std::hypot(0.7, 1.0) * 0.05;
  EXPECT_NEAR(std::sqrt(found[39](0, 0)), unknown * 20.0, 1e-9);
  EXPECT_NEAR(std::sqrt(found[79](0, 0)), unknown * 40.0, 1e-9);
  EXPECT_EQ(found[79](1, 1), 0.0);
  const Odometry given = weak_way(80, 20, 59, Forecast::kGiven);
  EXPECT_EQ(forecast_covariance(given, given.T_map_lidar, Pose::Identity())[79], Matrix6d::Zero());
}

// A heading that drifted moves the poses behind it aside.
TEST(ForecastCovariance, OfAHeadingGrowsBehindTheStretch) {
  Odometry odometry = weak_way(80, 20, 39, Forecast::kSteady);
  for (std::size_t k = 20; k < 40; ++k) odometry.constraint[k].weak = {0.0, 0.0, 1.0};
  const std::vector<Matrix6d> found =
      forecast_covariance(odometry, odometry.T_map_lidar, Pose::Identity());
  EXPECT_NEAR(std::sqrt(found[39](5, 5)), 0.02, 1e-9);
  EXPECT_NEAR(std::sqrt(found[79](5, 5)), 0.02, 1e-9);
  EXPECT_GT(std::sqrt(found[79](1, 1)), 0.02 * 40.0);
  EXPECT_EQ(found[79](0, 0), 0.0);
}

TEST(SteadyMotion, IsTheMeanOfTheLatestStepsExtendedToATime) {
  SteadyMotion motion;
  for (int i = 0; i < 4; ++i) motion.add({pose_at(1.0, 0.0, 0.0), 100});
  EXPECT_FALSE(motion.is_known());
  motion.add({pose_at(1.5, 0.0, 0.1), 100});
  ASSERT_TRUE(motion.is_known());
  const Pose step = motion.step(200);
  EXPECT_NEAR(step.translation().norm(), 2.2, 0.01);
  EXPECT_NEAR(rotation_angle_rad(step.linear()), 0.04, 1e-9);
}

// Houses up to x = 0, then bare walls; returns with 1 cm of noise. 30 m of houses are seen from
// within for a while, so that the walls alone remain behind x = 50 m. From there on steps are
// `later_share` as long.
struct TunnelDrive {
  std::size_t count = 120;
  double step_m = 1.2;
  double later_share = 1.0;
  double pillars_m = 0.0;  // between pillars along the bare walls; 0: none
  double change = 0.0;     // of the speed, in waves of 150 m
};
TestDrive tunnel_drive(const TunnelDrive& of) {
  BoxWorld world = bare_street();
  for (double x_m = 40.0; of.pillars_m > 0.0 && x_m < 250.0; x_m += of.pillars_m) {
    world.boxes.push_back({{x_m, 5.2, 0.0}, {x_m + 1.0, 6.0, 3.0}});
  }
  Random random(3);
  for (double x_m = -40.0; x_m < 0.0; x_m += 5.0) {
    const double depth_m = random.uniform(1.0, 2.5);
    world.boxes.push_back({{x_m, 6.0 - depth_m, 0.0}, {x_m + random.uniform(1.0, 3.0), 6.0, 5.0}});
    world.boxes.push_back({{x_m + 2.0, -6.0, 0.0}, {x_m + 3.5, -6.0 + depth_m, 4.0}});
  }
  std::vector<Pose> poses;
  double x_m = -20.0;
  for (std::size_t i = 0; i < of.count; ++i) {
    poses.push_back(pose_at(x_m, 0.2, 0.01));
    const double share = 1.0 + of.change * std::cos(x_m * 2.0 * std::numbers::pi / 150.0);
    x_m += share * (x_m < 50.0 ? of.step_m : of.later_share * of.step_m);
  }
  TestDrive test = drive_through(world, poses, 0.5);
  add_noise(0.01, random, test);
  return test;
}

// Speeds that are 1.5 % too high, 50 a second.
std::vector<WheelSpeed> wheel_speeds_of(const Trajectory& truth) {
  std::vector<WheelSpeed> speeds;
  for (std::size_t i = 1; i < truth.poses.size(); ++i) {
    const TrajectoryPose& from = truth.poses[i - 1];
    const double step_m =
        (truth.poses[i].T_map_vehicle.translation() - from.T_map_vehicle.translation()).norm();
    for (std::int64_t part = 0; part < 5; ++part) {
      speeds.push_back({from.stamp_ns + 20'000'000 * part, 1.015 * step_m / 0.1});
    }
  }
  speeds.push_back({truth.poses.back().stamp_ns, speeds.back().speed_m_s});
  return speeds;
}

TEST(Unconstrained, ATunnelHasTheLengthThatTheWheelsMeasured) {
  TestDrive test = tunnel_drive({.later_share = 0.7});
  TestContext without(2);
  const Trajectory steady = value_of(estimate_trajectory(without, {}, test.drive));
  EXPECT_GT(largest_error_m(steady, test.truth), 5.0);
  test.drive.wheel_speeds = wheel_speeds_of(test.truth);
  TestContext ctx(2);
  const Trajectory found = value_of(estimate_trajectory(ctx, {}, test.drive));
  EXPECT_LT(largest_error_m(found, test.truth), 1.0);
  ASSERT_EQ(ctx.warnings.size(), 1U);
  EXPECT_THAT(ctx.warnings[0], HasSubstr("not constrained along the road; wheel speed is used"));
  EXPECT_LT(found.poses.back().covariance(0, 0), 1.0);
}

TEST(Unconstrained, ATunnelKeepsItsLengthWhichIsSaid) {
  const TestDrive test = tunnel_drive({});
  TestContext ctx(2);
  const Trajectory found = value_of(estimate_trajectory(ctx, {}, test.drive));
  EXPECT_LT(largest_error_m(found, test.truth), 0.02 * 119 * 1.2);
  ASSERT_EQ(ctx.warnings.size(), 1U);
  EXPECT_THAT(ctx.warnings[0], HasSubstr("not constrained along the road; constant speed"));
  EXPECT_GT(found.poses.back().covariance(0, 0), 1.0) << "several metres are not known";
  const std::vector<UnconstrainedStretch> stretches = unconstrained_stretches(found);
  ASSERT_FALSE(stretches.empty());
  EXPECT_TRUE(stretches.back().directions.along);
  EXPECT_EQ(stretches.back().directions.substitute, Substitute::kConstantSpeed);
  EXPECT_NEAR(stretches.back().sigma_m.value(), 0.05 * stretches.back().way_m,
              0.2 * stretches.back().sigma_m.value());
}

// A speed that stayed as it was at the entrance would be metres off at the end, and would blur the
// pillars.
TEST(Unconstrained, PillarsHoldATunnelAtAChangingSpeed) {
  const TestDrive test = tunnel_drive({.pillars_m = 20.0, .change = 0.05});
  TestContext ctx(2);
  const Trajectory found = value_of(estimate_trajectory(ctx, {}, test.drive));
  EXPECT_LT(largest_error_m(found, test.truth), 0.5);
  EXPECT_THAT(ctx.warnings, testing::IsEmpty());
}

// The rear of a lorry that drives ahead, a little slower or faster, is all that is seen along the
// way.
TEST(Unconstrained, ATunnelKeepsItsLengthBehindALorry) {
  const TestDrive alone = tunnel_drive({});
  const BoxWorld tube = bare_street();
  std::vector<Scan> scans = scans_of(alone.drive);
  std::vector<Pose> poses;
  Random random(11);
  for (std::size_t k = 0; k < scans.size(); ++k) {
    poses.push_back(alone.truth.poses[k].T_map_vehicle);
    const double x_m = poses[k].translation().x();
    if (x_m < 20.0) continue;
    const double gap_m = 9.0 + 2.0 * std::cos(0.05 * (x_m - 20.0));
    BoxWorld world = tube;
    world.boxes.push_back({{x_m + gap_m, 1.5, 0.9}, {x_m + gap_m + 12.0, 4.0, 3.9}});
    scans[k] = scan_world(world, poses[k] * alone.drive.sensor.T_vehicle_lidar, 0.5);
    for (Eigen::Vector3d& point_m : scans[k].points_m) {
      point_m *= 1.0 + 0.01 * random.normal() / point_m.norm();
    }
  }
  TestDrive test = drive_of(std::move(scans), poses);
  test.drive.sensor = alone.drive.sensor;
  TestContext ctx(2);
  const Trajectory found = value_of(estimate_trajectory(ctx, {}, test.drive));
  EXPECT_LT(largest_error_m(found, test.truth), 0.05 * 119 * 1.2);
  const std::vector<UnconstrainedStretch> stretches = unconstrained_stretches(found);
  ASSERT_FALSE(stretches.empty());
  double way_m = 0.0;
  for (const UnconstrainedStretch& stretch : stretches) way_m += stretch.way_m;
  EXPECT_GT(way_m, 40.0);
}

TEST(Unconstrained, GivenPosesOfATunnelStayWithoutAWarning) {
  TestDrive test = tunnel_drive({.count = 80});
  for (std::size_t i = 0; i < test.drive.scans.size(); ++i) {
    test.drive.scans[i].T_world_vehicle = test.truth.poses[i].T_map_vehicle;
  }
  TestContext ctx(2);
  const Trajectory kept = value_of(estimate_trajectory(ctx, {}, test.drive));
  EXPECT_EQ(kept.source, PoseSource::kGiven);
  EXPECT_THAT(ctx.warnings, testing::IsEmpty());
  const std::vector<UnconstrainedStretch> stretches = unconstrained_stretches(kept);
  ASSERT_FALSE(stretches.empty()) << "given poses are used there, which is said";
  for (const UnconstrainedStretch& stretch : stretches) {
    EXPECT_EQ(stretch.directions.substitute, Substitute::kGivenPoses);
  }
  const EstimateTrajectoryOptions refine{.mode = PoseMode::kRefine};
  const Trajectory refined = value_of(estimate_trajectory(ctx, refine, test.drive));
  EXPECT_LT(largest_error_m(refined, test.truth), 0.05);
}

}  // namespace
}  // namespace sightline

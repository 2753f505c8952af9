#include "passes/trajectory/following/speed_forecast.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "formats/base/random.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/following/smoothed_ways.h"
#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

constexpr double kGravity_m_s2 = 9.80665;
constexpr std::int64_t kScanStep_ns = 100'000'000;

TEST(SampleIntegral, IsExactForSamplesThatChangeLinearly) {
  SampleIntegral integral(kScanStep_ns);
  for (int i = 0; i <= 10; ++i) {
    integral.add(100'000'000 * i, Eigen::Vector3d(2.0 + 0.3 * i, 1.0, 0.0));
  }
  // v = 2 + 3 t from 0.25 s to 0.85 s.
  const auto found = integral.between(250'000'000, 850'000'000);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->once.x(), 2.75 * 0.6 + 1.5 * 0.36, 1e-12);
  EXPECT_NEAR(found->twice.x(), 2.75 * 0.18 + 0.5 * 0.216, 1e-12);
  EXPECT_NEAR(found->once.y(), 0.6, 1e-12);
  EXPECT_NEAR(integral.between(300'000'000, 300'000'000)->once.norm(), 0.0, 1e-12);
}

TEST(SampleIntegral, IsNoneOutsideOfTheSamplesAndAcrossGaps) {
  SampleIntegral integral(kScanStep_ns);
  EXPECT_FALSE(integral.between(0, 0).has_value());
  for (const std::int64_t tenths : {0, 1, 2, 5, 6}) {
    integral.add(100'000'000 * tenths, Eigen::Vector3d::UnitX());
  }
  EXPECT_TRUE(integral.between(0, 200'000'000).has_value());
  EXPECT_TRUE(integral.between(500'000'000, 600'000'000).has_value());
  EXPECT_FALSE(integral.between(100'000'000, 300'000'000).has_value());
  EXPECT_FALSE(integral.between(250'000'000, 260'000'000).has_value());
  EXPECT_FALSE(integral.between(0, 600'000'000).has_value());
  EXPECT_FALSE(integral.between(-1, 100'000'000).has_value());
  EXPECT_FALSE(integral.between(500'000'000, 600'000'001).has_value());
}

TEST(WheelScale, IsTheRatioOfTheWaysAndSurerWithTheWay) {
  WheelScale scale;
  EXPECT_EQ(scale.way_per_wheel(), 1.0);
  EXPECT_EQ(scale.sigma(), 0.02);
  for (int i = 0; i < 5; ++i) scale.add(1.0, 1.015);
  const double after_five = scale.sigma();
  EXPECT_LT(after_five, 0.01);
  for (int i = 0; i < 95; ++i) scale.add(1.0, 1.015);
  scale.add(0.2, 1.015);  // a wheel that spins
  EXPECT_NEAR(scale.way_per_wheel(), 1.0 / 1.015, 0.001);
  EXPECT_LT(scale.sigma(), after_five);
  EXPECT_FALSE(scale.is_contradicted());
}

TEST(WheelScale, IsContradictedByAnotherUnit) {
  WheelScale scale;
  for (int i = 0; i < 19; ++i) scale.add(1.0, 3.6);
  EXPECT_FALSE(scale.is_contradicted());
  scale.add(1.0, 3.6);
  EXPECT_TRUE(scale.is_contradicted());
  EXPECT_EQ(scale.way_per_wheel(), 1.0);
}

TEST(WayCheck, RefutesAWayThatIsOffAndSeveralThatAreEachALittleShort) {
  WayCheck check;
  EXPECT_FALSE(check.refutes(0.04, 0.004));
  EXPECT_TRUE(check.refutes(-0.05, 0.004));
  for (int i = 0; i < 20; ++i) check.take(-0.02);
  EXPECT_TRUE(check.refutes(-0.02, 0.001));
  EXPECT_FALSE(WayCheck().refutes(-0.02, 0.001));
}

// A straight road that climbs by `climb`, driven with a speed over time; scans 0.1 s apart.
struct Road {
  double climb = 0.0;
  std::function<double(double)> speed_m_s;
  double wheel_scale = 1.0;
  double bias_m_s2 = 0.0;
  double sensor_yaw_rad = 0.0;

  [[nodiscard]] double acceleration_m_s2(double time_s) const {
    return (speed_m_s(time_s + 1e-4) - speed_m_s(time_s - 1e-4)) / 2e-4;
  }
  [[nodiscard]] Drive drive(std::size_t scans, bool has_wheels, bool has_forces) const {
    Drive drive;
    drive.name = "road";
    drive.scans.resize(scans);
    for (std::size_t k = 0; k < scans; ++k) {
      drive.scans[k].stamp_ns = kScanStep_ns * static_cast<std::int64_t>(k);
      drive.scans[k].recording_index = static_cast<std::uint32_t>(k);
    }
    const std::int64_t end_ns = kScanStep_ns * static_cast<std::int64_t>(scans);
    for (std::int64_t time_ns = 0; time_ns <= end_ns; time_ns += 10'000'000) {
      const double time_s = 1e-9 * static_cast<double>(time_ns);
      if (has_wheels) drive.wheel_speeds.push_back({time_ns, wheel_scale * speed_m_s(time_s)});
      if (!has_forces) continue;
      // Of the vehicle as the drive has it: its axes are those of the sensor.
      const double ahead_m_s2 = acceleration_m_s2(time_s) + kGravity_m_s2 * climb + bias_m_s2;
      drive.specific_forces.push_back(
          {time_ns, pose_at(0.0, 0.0, -sensor_yaw_rad).linear() *
                        Eigen::Vector3d(ahead_m_s2, 0.0, kGravity_m_s2)});
    }
    return drive;
  }
  [[nodiscard]] std::vector<Pose> poses(std::size_t scans) const {
    std::vector<Pose> poses;
    double way_m = 0.0;
    for (std::size_t k = 0; k < scans; ++k) {
      Pose pose = Pose::Identity();
      const Eigen::Vector3d ahead = Eigen::Vector3d(std::sqrt(1.0 - climb * climb), 0.0, climb);
      pose.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), ahead) *
                      pose_at(0.0, 0.0, sensor_yaw_rad).linear();
      pose.translation() = way_m * ahead;
      poses.push_back(pose);
      for (int i = 0; i < 100; ++i) {
        way_m += 0.001 * speed_m_s(0.1 * static_cast<double>(k) + 0.001 * (i + 0.5));
      }
    }
    return poses;
  }
};

// A vehicle at about 10 m/s that slows down by 1 m/s from 10 s to 15 s.
double uneven_m_s(double time_s) {
  return time_s < 10.0 ? 10.0 : time_s > 15.0 ? 9.0 : 10.0 - 0.2 * (time_s - 10.0);
}

// The odometry of these poses, whose ways from `first` to `last` are `share` of the true ones and
// not constrained along the road.
Odometry odometry_of(const std::vector<Pose>& poses, std::size_t first, std::size_t last,
                     Forecast forecast, double share) {
  Odometry odometry;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    Pose step = k == 0 ? Pose::Identity() : poses[k - 1].inverse() * poses[k];
    const bool is_weak = k >= first && k <= last;
    if (is_weak) step.translation() *= share;
    odometry.append(k == 0 ? poses[0] : odometry.T_map_lidar.back() * step,
                    step.translation().norm(), true, {});
    if (is_weak) {
      odometry.constraint.back() = {1.0, Eigen::Vector3d::UnitX(), forecast,
                                    Eigen::Matrix3d::Identity(), 0.0};
    }
  }
  return odometry;
}

double error_m(const Odometry& odometry, const std::vector<Pose>& poses) {
  return (odometry.T_map_lidar.back().translation() - poses.back().translation()).norm();
}

// The poses up to scan `count`, each step constrained, and the forecast of the next step.
std::optional<SpeedForecast::Way> forecast_after(const Drive& drive, const std::vector<Pose>& poses,
                                                 std::size_t count) {
  SpeedForecast forecast(drive);
  for (std::size_t k = 1; k < count; ++k) {
    forecast.take({drive.scans[k - 1].stamp_ns, drive.scans[k].stamp_ns, poses[k - 1], poses[k]},
                  true);
  }
  return forecast.way({drive.scans[count - 1].stamp_ns, drive.scans[count].stamp_ns,
                       poses[count - 1], poses[count - 1]});
}

TEST(SpeedForecast, ByWheelsHasTheirScaleAndTheirSign) {
  for (const double direction : {1.0, -1.0}) {
    Road road{0.0, [&](double) { return 8.0 * direction; }};
    road.wheel_scale = 1.04;
    const Drive drive = road.drive(60, true, true);
    const std::optional<SpeedForecast::Way> way = forecast_after(drive, road.poses(60), 50);
    ASSERT_TRUE(way.has_value());
    EXPECT_EQ(way->source, Forecast::kWheels);
    EXPECT_NEAR(way->moved_m.x(), 0.8 * direction, 0.005);
    EXPECT_LT(way->share, 0.01);
  }
}

TEST(SpeedForecast, ByAccelerationsLearnsTheBiasAndRemovesGravity) {
  for (const double climb : {0.0, 0.08}) {
    Road road{climb, [](double time_s) { return 5.0 + 0.5 * time_s; }};
    road.bias_m_s2 = 0.15;
    const Drive drive = road.drive(101, false, true);
    const std::optional<SpeedForecast::Way> way = forecast_after(drive, road.poses(101), 100);
    ASSERT_TRUE(way.has_value());
    EXPECT_EQ(way->source, Forecast::kInertial);
    EXPECT_NEAR(way->moved_m.norm(), 0.9975, 0.002) << climb;
  }
  const Road road{0.0, [](double) { return 5.0; }};
  const Drive drive = road.drive(30, false, true);
  EXPECT_FALSE(forecast_after(drive, road.poses(30), 10).has_value()) << "nine steps";
  EXPECT_TRUE(forecast_after(drive, road.poses(30), 11).has_value());
  EXPECT_FALSE(forecast_after(road.drive(30, false, false), road.poses(30), 20).has_value());
}

// The mounting of a sensor may not be known: the way is along the steps.
TEST(SpeedForecast, IsAlongTheMotionOfASensorThatLooksAside) {
  Road road{0.0, [](double) { return 8.0; }};
  road.sensor_yaw_rad = 1.2;
  const Drive drive = road.drive(60, true, true);
  const Eigen::Vector3d ahead = pose_at(0.0, 0.0, -1.2).linear().col(0);
  EXPECT_NEAR((forecast_after(drive, road.poses(60), 50)->moved_m - 0.8 * ahead).norm(), 0.0, 0.01);
  const Drive by_forces = road.drive(60, false, true);
  EXPECT_NEAR((forecast_after(by_forces, road.poses(60), 50)->moved_m - 0.8 * ahead).norm(), 0.0,
              0.01);
}

TEST(SmoothedWays, ByWheelsHaveTheScaleOfTheWholeDrive) {
  Road road{0.0, uneven_m_s};
  road.wheel_scale = 0.985;
  const std::vector<Pose> poses = road.poses(300);
  Odometry odometry = odometry_of(poses, 50, 249, Forecast::kWheels, 1.0 / 0.985);
  TestContext ctx;
  smooth_forecasts(ctx, road.drive(300, true, true), odometry);
  EXPECT_LT(error_m(odometry, poses), 0.002 * 200.0);
  EXPECT_NEAR(odometry.driven_m.back(), poses.back().translation().norm(), 0.4);
  EXPECT_LT(odometry.constraint[100].way_share, 0.005);
  EXPECT_GT(odometry.constraint[100].way_share, 0.001);
  EXPECT_TRUE(ctx.warnings.empty());
}

// The forecast was 3 % short; the speeds at both ends and the accelerations between them give the
// way, and an error that is said.
TEST(SmoothedWays, ByAccelerationsMeetTheSpeedsAtBothEnds) {
  Road road{0.03, uneven_m_s};
  road.bias_m_s2 = -0.05;
  const std::vector<Pose> poses = road.poses(300);
  Odometry odometry = odometry_of(poses, 50, 249, Forecast::kInertial, 0.97);
  ASSERT_GT(error_m(odometry, poses), 5.0);
  smooth_forecasts(TestContext(), road.drive(300, false, true), odometry);
  const double sigma_m = odometry.constraint[100].way_share * 190.0;
  EXPECT_LT(error_m(odometry, poses), 1.0);
  EXPECT_LT(error_m(odometry, poses), 3.0 * sigma_m);
  EXPECT_LT(sigma_m, 4.0);
}

TEST(SmoothedWays, LeaveStepsAloneThatScansConstrainOrGivenPosesLead) {
  const Road road{0.0, uneven_m_s};
  const std::vector<Pose> poses = road.poses(100);
  for (const Forecast forecast : {Forecast::kGiven, Forecast::kSteady}) {
    Odometry odometry = odometry_of(poses, 50, 89, forecast, 0.9);
    const Odometry before = odometry;
    smooth_forecasts(TestContext(), road.drive(100, true, true), odometry);
    for (std::size_t k = 0; k < poses.size(); ++k) {
      EXPECT_EQ(odometry.T_map_lidar[k].matrix(), before.T_map_lidar[k].matrix());
    }
  }
}

// Where scans constrain every step, the poses are those without such sensors, to the last bit.
TEST(SpeedForecast, LeavesAStreetAsItIs) {
  std::vector<Pose> poses;
  for (int i = 0; i < 40; ++i) poses.push_back(pose_at(0.7 * i, 0.0, 0.0));
  TestDrive test = drive_through(random_street(4), poses, 0.5);
  TestContext ctx(2);
  const GivenPoses none(poses.size());
  const Odometry without = value_of(run_odometry(ctx, 50.0, test.drive, none));
  Road road{0.0, [](double) { return 7.0; }};
  road.wheel_scale = 1.03;
  const Drive sensed = road.drive(poses.size(), true, true);
  test.drive.wheel_speeds = sensed.wheel_speeds;
  test.drive.specific_forces = sensed.specific_forces;
  Odometry with = value_of(run_odometry(ctx, 50.0, test.drive, none));
  smooth_forecasts(ctx, test.drive, with);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    EXPECT_EQ(with.T_map_lidar[k].matrix(), without.T_map_lidar[k].matrix()) << k;
  }
  EXPECT_TRUE(ctx.warnings.empty());
}

// The vehicle brakes within the stretch, so that another clock is metres of way.
TEST(SmoothedWays, HaveTheWheelsOnTheClockOfTheScans) {
  const Road road{0.0, [](double time_s) {
                    return 12.0 + 2.0 * std::sin(0.8 * time_s) - (time_s > 15.0 ? 8.0 : 0.0);
                  }};
  const std::vector<Pose> poses = road.poses(300);
  Drive drive = road.drive(300, true, false);
  for (WheelSpeed& speed : drive.wheel_speeds) speed.stamp_ns += 300'000'000;
  Odometry odometry = odometry_of(poses, 120, 179, Forecast::kWheels, 0.95);
  TestContext ctx;
  smooth_forecasts(ctx, drive, odometry);
  EXPECT_LT(error_m(odometry, poses), 0.5);
  ASSERT_EQ(ctx.warnings.size(), 1U);
  EXPECT_NE(ctx.warnings[0].find("the clock of the wheel speeds is 0.30 s ahead of"),
            std::string::npos)
      << ctx.warnings[0];
}

TEST(SmoothedWays, WarnWhereWheelsContradictTheScans) {
  Road road{0.0, uneven_m_s};
  road.wheel_scale = 3.6;
  Odometry odometry = odometry_of(road.poses(60), 60, 60, Forecast::kNone, 1.0);
  TestContext ctx;
  smooth_forecasts(ctx, road.drive(60, true, false), odometry);
  ASSERT_EQ(ctx.warnings.size(), 1U);
  EXPECT_NE(ctx.warnings[0].find("most wheel speeds differ by more than 10 %"), std::string::npos);
}

}  // namespace
}  // namespace sightline

#include "passes/trajectory/undistort_scans.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

#include "formats/base/random.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
constexpr std::int64_t kPeriod_ns = 100'000'000;

// A hall of 60 x 40 x 8 m around the origin; where a ray from inside ends.
Eigen::Vector3d wall_hit_m(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d half_m(30.0, 20.0, 4.0);
  double least_m = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) continue;
    const double wall_m = direction[axis] > 0.0 ? half_m[axis] : -half_m[axis];
    least_m = std::min(least_m, (wall_m - from_m[axis]) / direction[axis]);
  }
  return from_m + least_m * direction;
}

double off_the_walls_m(const Eigen::Vector3d& point_m) {
  const Eigen::Vector3d half_m(30.0, 20.0, 4.0);
  double least_m = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    least_m = std::min(least_m, std::abs(half_m[axis] - std::abs(point_m[axis])));
  }
  return least_m;
}

struct Arc {
  double speed_mps = 0.0;
  double yaw_rate_radps = 0.0;
  double roll_rate_radps = 0.0;

  [[nodiscard]] Pose at(double time_s) const {
    Pose T_map_vehicle = Pose::Identity();
    const double yaw_rad = yaw_rate_radps * time_s;
    const double chord_m = yaw_rate_radps == 0.0
                               ? speed_mps * time_s
                               : 2.0 * speed_mps / yaw_rate_radps * std::sin(yaw_rad / 2.0);
    T_map_vehicle.translation() = Eigen::Vector3d(-10.0 + chord_m * std::cos(yaw_rad / 2.0),
                                                  chord_m * std::sin(yaw_rad / 2.0), 0.0);
    T_map_vehicle.rotate(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
    T_map_vehicle.rotate(Eigen::AngleAxisd(roll_rate_radps * time_s, Eigen::Vector3d::UnitX()));
    return T_map_vehicle;
  }
};

struct Journey {
  Drive drive;
  Trajectory trajectory;
};

// Scans measured point by point while the vehicle drives; times run from `first` to `first` + 1 of
// a period, 0 being the stamp.
Journey drive_along(const Arc& arc, int scans, double first = 0.0) {
  Journey journey;
  journey.drive.name = "hall";
  journey.drive.sensor.beam_elevations_deg = {-10.0, 10.0};
  journey.drive.sensor.T_vehicle_lidar.translation() = Eigen::Vector3d(1.2, -0.4, 0.8);
  journey.drive.sensor.T_vehicle_lidar.rotate(
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.1, 0.2, 1.0).normalized()));
  std::vector<Scan> made;
  Random random(11);
  for (int k = 0; k < scans; ++k) {
    Scan& scan = made.emplace_back();
    scan.stamp_ns = 1'700'000'000'000'000'000 + k * kPeriod_ns;
    for (int i = 0; i < 300; ++i) {
      const double share = first + i / 300.0;
      const double time_s = 1e-9 * static_cast<double>(kPeriod_ns) * (k + share);
      const Pose T_map_lidar = arc.at(time_s) * journey.drive.sensor.T_vehicle_lidar;
      const double azimuth = 2.0 * std::numbers::pi * share;
      const Eigen::Vector3d ray(std::cos(azimuth), std::sin(azimuth), random.uniform(-0.2, 0.2));
      scan.points_m.push_back(
          T_map_lidar.inverse() *
          wall_hit_m(T_map_lidar.translation(), T_map_lidar.linear() * ray.normalized()));
      scan.time_offset_ns.push_back(
          static_cast<std::int32_t>(std::lround(share * static_cast<double>(kPeriod_ns))));
    }
    ScanInfo& info = journey.drive.scans.emplace_back();
    info.recording_index = static_cast<std::uint32_t>(k);
    info.stamp_ns = scan.stamp_ns;
    info.has_point_times = true;
    journey.trajectory.poses.push_back({info.recording_index, scan.stamp_ns, arc.at(0.1 * k)});
  }
  journey.drive = with_store(journey.drive, memory_scan_store(std::move(made)));
  return journey;
}

// The farthest that a point of a scan is off the walls where its own pose puts it.
double worst_m(const Drive& drive, const Trajectory& trajectory, std::size_t index) {
  const Scan scan = value_of(drive.store->read(index));
  const Pose T_map_lidar = trajectory.poses[index].T_map_vehicle * drive.sensor.T_vehicle_lidar;
  double worst = 0.0;
  for (const Eigen::Vector3d& point_m : scan.points_m) {
    worst = std::max(worst, off_the_walls_m(T_map_lidar * point_m));
  }
  return worst;
}

TEST(UndistortScans, MovesAPointByWhatTheVehicleMovedSinceItsTime) {
  Journey journey = drive_along({10.0, 0.0, 0.0}, 2);
  journey.drive.sensor.T_vehicle_lidar = Pose::Identity();
  Scan scan;
  scan.stamp_ns = journey.drive.scans[0].stamp_ns;
  scan.points_m = {Eigen::Vector3d(5, 0, 0), Eigen::Vector3d(5, 0, 0), Eigen::Vector3d(5, 0, 0)};
  scan.time_offset_ns = {0, 25'000'000, -50'000'000};
  journey.drive = with_store(journey.drive, memory_scan_store({scan, scan}));
  const Drive drive =
      value_of(undistort_scans(TestContext(), {}, journey.drive, journey.trajectory));
  const Scan read = value_of(drive.store->read(0));
  EXPECT_NEAR(read.points_m[0].x(), 5.0, 1e-12);
  EXPECT_NEAR(read.points_m[1].x(), 5.25, 1e-12);  // 10 m/s for 25 ms farther on
  EXPECT_NEAR(read.points_m[2].x(), 4.5, 1e-12);
  EXPECT_TRUE(read.time_offset_ns.empty());
  EXPECT_FALSE(drive.scans[0].has_point_times);
}

TEST(UndistortScans, PutsPointsOnTheWallsThatTheyLeftWhileDriving) {
  for (const double first : {0.0, -0.5, -1.0}) {
    // Even motion between poses is exact here, at both ends as well.
    const Journey straight = drive_along({15.0, 0.0, 0.8}, 5, first);
    const Drive level =
        value_of(undistort_scans(TestContext(), {}, straight.drive, straight.trajectory));
    // On an arc the chord is off by speed x rate x period^2 / 8 = 2 mm, behind the ends by more.
    const Journey turning = drive_along({8.0, 0.2, 0.1}, 5, first);
    const Drive turned =
        value_of(undistort_scans(TestContext(), {}, turning.drive, turning.trajectory));
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_GT(worst_m(straight.drive, straight.trajectory, k), 0.5) << k;
      EXPECT_LT(worst_m(level, straight.trajectory, k), 1e-6) << k;
      EXPECT_GT(worst_m(turning.drive, turning.trajectory, k), 0.25) << k;
      EXPECT_LT(worst_m(turned, turning.trajectory, k), k == 0 || k == 4 ? 0.02 : 0.004) << k;
    }
  }
}

TEST(UndistortScans, KeepsWhatHasNoTimesAndIsDoneOnlyOnce) {
  Journey journey = drive_along({10.0, 0.3, 0.0}, 3);
  PassContext ctx;
  const Drive once = value_of(undistort_scans(ctx, {}, journey.drive, journey.trajectory));
  EXPECT_EQ(once.store, value_of(undistort_scans(ctx, {}, once, journey.trajectory)).store);
  for (ScanInfo& scan : journey.drive.scans) scan.has_point_times = false;
  EXPECT_EQ(undistort_scans(ctx, {}, journey.drive, journey.trajectory)->store,
            journey.drive.store);
}

TEST(UndistortScans, CanBeTurnedOffWithAWarning) {
  const Journey journey = drive_along({10.0, 0.3, 0.0}, 3);
  TestContext ctx;
  const Drive drive =
      value_of(undistort_scans(ctx, {.enabled = false}, journey.drive, journey.trajectory));
  EXPECT_EQ(drive.store, journey.drive.store);
  EXPECT_TRUE(drive.scans[0].has_point_times);
  EXPECT_THAT(ctx.warnings, ElementsAre(HasSubstr("3 scans have point times that are not used")));
}

TEST(UndistortScans, DoesNotMoveAcrossAGap) {
  Journey journey = drive_along({10.0, 0.0, 0.0}, 4);
  // After scan 1 the recording pauses; the vehicle is 40 m farther on after 4 s.
  for (std::size_t k : {2U, 3U}) {
    journey.drive.scans[k].stamp_ns += 4'000'000'000;
    journey.trajectory.poses[k].stamp_ns += 4'000'000'000;
  }
  TestContext ctx;
  const Drive drive = value_of(undistort_scans(ctx, {}, journey.drive, journey.trajectory));
  EXPECT_LT(worst_m(drive, journey.trajectory, 1), 1e-6);  // goes on as from scan 0 to 1
  EXPECT_TRUE(ctx.warnings.empty());
  Journey lonely = drive_along({10.0, 0.0, 0.0}, 1);
  const Drive still = value_of(undistort_scans(ctx, {}, lonely.drive, lonely.trajectory));
  EXPECT_EQ(still.store->read(0)->points_m, lonely.drive.store->read(0)->points_m);
  EXPECT_THAT(ctx.warnings, ElementsAre(HasSubstr("1 scans have no other pose within 1.5 s")));
}

// Scans are missing after scan 1, and stamps that were made up do not say so.
TEST(UndistortScans, DoesNotMoveByAStepThatIsOutOfKeepingWithThoseBesideIt) {
  Journey journey = drive_along({10.0, 0.0, 0.0}, 5);
  for (std::size_t k : {2U, 3U, 4U}) {
    journey.trajectory.poses[k].T_map_vehicle.translation().x() += 5.0;
  }
  const Drive drive =
      value_of(undistort_scans(TestContext(), {}, journey.drive, journey.trajectory));
  EXPECT_LT(worst_m(drive, journey.trajectory, 1), 1e-6);
}

TEST(UndistortScans, NamesScansByTheMotionAroundThem) {
  constexpr std::size_t kScans = 80;
  const Journey before = drive_along({10.0, 0.3, 0.0}, kScans, -0.5);
  Journey after = before;
  after.trajectory.poses[30].T_map_vehicle.translation().y() += 0.1;
  const Drive was = *undistort_scans(TestContext(), {}, before.drive, before.trajectory);
  const Drive is = *undistort_scans(TestContext(), {}, after.drive, after.trajectory);
  std::size_t same = 0;
  for (std::size_t k = 0; k < kScans; ++k) {
    const bool is_same = was.store->identity(k) == is.store->identity(k);
    same += is_same ? 1 : 0;
    EXPECT_TRUE(was.store->read(k)->points_m == is.store->read(k)->points_m || !is_same) << k;
    EXPECT_TRUE(is_same || k <= 60) << "3 s behind it: " << k;
    EXPECT_NE(was.store->identity(k), before.drive.store->identity(k));
  }
  EXPECT_GT(same, 20U);
}

TEST(UndistortScans, RefusesATrajectoryOfAnotherDrive) {
  Journey journey = drive_along({10.0, 0.0, 0.0}, 3);
  journey.trajectory.poses.pop_back();
  EXPECT_EQ(undistort_scans(TestContext(), {}, journey.drive, journey.trajectory).error().code,
            ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline

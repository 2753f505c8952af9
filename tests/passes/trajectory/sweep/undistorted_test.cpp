#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "passes/trajectory/sweep/undistorted.h"
#include "passes/trajectory/undistort_scans.h"
#include "tests/passes/trajectory/sweep/uneven_town.h"
#include "tests/passes/trajectory/sweep/uneven_turns.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

// Turns on the spot, so that nothing but turning is in a scan.
Pose spinning(double time_s) {
  Pose pose = jerky(time_s);
  pose.translation().setZero();
  return pose;
}

TEST(WithoutTurning, LeavesAScanOfAVehicleOnTheSpotAsIfMeasuredAtOnce) {
  TestDrive test = timed_drive(random_street(2), spinning, 3);
  test.drive.turn_rates = imu_of(spinning, 1.0);
  const Drive straight = without_turning(test.drive);
  for (std::size_t k = 0; k < 3; ++k) {
    const Scan raw = *test.drive.store->read(k);
    const Scan scan = *straight.store->read(k);
    EXPECT_EQ(scan.time_offset_ns, raw.time_offset_ns);
    const Pose T_map_lidar =
        spinning(0.1 * static_cast<double>(k)) * test.drive.sensor.T_vehicle_lidar;
    double worst_before_m = 0.0;
    double worst_m = 0.0;
    for (std::size_t i = 0; i < raw.points_m.size(); ++i) {
      const double time_s = 1e-9 * static_cast<double>(raw.stamp_ns + raw.time_offset_ns[i]);
      const Eigen::Vector3d hit_m =
          spinning(time_s) * test.drive.sensor.T_vehicle_lidar * raw.points_m[i];
      worst_before_m = std::max(worst_before_m, (T_map_lidar * raw.points_m[i] - hit_m).norm());
      worst_m = std::max(worst_m, (T_map_lidar * scan.points_m[i] - hit_m).norm());
    }
    EXPECT_GT(worst_before_m, 0.5);
    EXPECT_LT(worst_m, 0.005);
  }
}

TEST(WithoutTurning, LeavesScansThatRatesDoNotCover) {
  TestDrive test = timed_drive(random_street(2), spinning, 3);
  std::vector<TurnRate> rates = imu_of(spinning, 1.0);
  std::erase_if(rates, [](const TurnRate& rate) { return rate.stamp_ns > 130'000'000; });
  test.drive.turn_rates = rates;
  const Drive straight = without_turning(test.drive);
  EXPECT_NE(straight.store->read(0)->points_m, test.drive.store->read(0)->points_m);
  EXPECT_EQ(straight.store->read(2)->points_m, test.drive.store->read(2)->points_m);
  EXPECT_NE(straight.store->identity(0), test.drive.store->identity(0));
}

TEST(UndistortUnevenTown, HasItsPointsNearerToTheTruthWithTurnRates) {
  UnevenTown town;
  TestContext ctx;
  const Drive even = value_of(undistort_scans(ctx, {}, town.recorded, town.given));
  town.recorded.turn_rates = town::imu_of(town.drive, 5);
  ctx.warnings.clear();
  const Drive turned = value_of(undistort_scans(ctx, {}, town.recorded, town.given));
  EXPECT_THAT(ctx.warnings, testing::Contains(testing::HasSubstr("turn rates are used")));
  const double even_m = error_m(town, even);
  const double turned_m = error_m(town, turned);
  RecordProperty("even_mm", static_cast<int>(1e3 * even_m));
  RecordProperty("turned_mm", static_cast<int>(1e3 * turned_m));
  EXPECT_GT(even_m, 0.05);
  EXPECT_LT(turned_m, 0.25 * even_m) << even_m;
}

}  // namespace
}  // namespace sightline

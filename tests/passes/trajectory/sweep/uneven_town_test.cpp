#include <gtest/gtest.h>

#include "examples/town/bag/imu.h"
#include "examples/town/drive.h"
#include "passes/trajectory/undistort_scans.h"

// A generated town driven by somebody who steers to and fro, given poses that are off and an
// inertial unit with bias and noise: how far undistorted points lie from where they were measured.

namespace sightline {
namespace {

struct Town {
  town::Town town = *town::make_town({3, 60.0});
  town::DriveSimulator drive = made();
  Drive recorded = town::recorded(drive, "town", drive.disturbed_poses(), 0);
  Trajectory given;

  Town() {
    for (const ScanInfo& scan : recorded.scans) {
      given.poses.push_back({scan.recording_index, scan.stamp_ns, *scan.T_world_vehicle});
    }
  }

 private:
  town::DriveSimulator made() const {
    town::DriveOptions options = town::usual_drive(town.options, 0, *town::town_sensor(16));
    options.length_m = 24.0;
    options.is_swept = true;
    options.sensor.azimuth_step_deg = 1.0;
    return *town::DriveSimulator::make(town, options);
  }
};

// Root mean square, beside what the scan's own pose is off.
double error_m(const Town& town, const Drive& straight) {
  double sum_m2 = 0.0;
  std::size_t count = 0;
  const Pose T_vehicle_lidar = straight.sensor.T_vehicle_lidar;
  for (std::size_t k = 1; k + 1 < straight.scans.size(); ++k) {
    const Scan raw = *town.recorded.store->read(k);
    const Scan scan = *straight.store->read(k);
    for (std::size_t i = 0; i < raw.points_m.size(); ++i) {
      const double time_s = 1e-9 * static_cast<double>(raw.stamp_ns + raw.time_offset_ns[i]);
      const Pose T_then_now = (town.drive.T_town_vehicle_at(time_s) * T_vehicle_lidar).inverse() *
                              town.drive.T_town_vehicle()[k] * T_vehicle_lidar;
      sum_m2 += (T_then_now * scan.points_m[i] - raw.points_m[i]).squaredNorm();
      ++count;
    }
  }
  return std::sqrt(sum_m2 / static_cast<double>(count));
}

TEST(UnevenTown, HasItsPointsNearerToTheTruthWithTurnRates) {
  Town town;
  PassContext ctx;
  const Result<Drive> even = undistort_scans(ctx, {}, town.recorded, town.given);
  town.recorded.turn_rates = town::imu_of(town.drive, 5);
  std::string said;
  ctx.warning_sink = [&](const std::string& message) { said += message + "\n"; };
  const Result<Drive> turned = undistort_scans(ctx, {}, town.recorded, town.given);
  ASSERT_TRUE(even.has_value() && turned.has_value());
  EXPECT_NE(said.find("turn rates are used"), std::string::npos) << said;
  const double even_m = error_m(town, *even);
  const double turned_m = error_m(town, *turned);
  RecordProperty("even_mm", static_cast<int>(1e3 * even_m));
  RecordProperty("turned_mm", static_cast<int>(1e3 * turned_m));
  EXPECT_GT(even_m, 0.05);
  EXPECT_LT(turned_m, 0.25 * even_m) << even_m;
}

}  // namespace
}  // namespace sightline

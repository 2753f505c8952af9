#pragma once

#include <cmath>
#include <cstddef>

#include "examples/town/bag/imu.h"
#include "examples/town/drive/drive.h"
#include "formats/drive/trajectory.h"

// A generated town, driven with an unsteady wheel, with inaccurate given poses and an inertial unit
// with bias and noise: how far undistorted points are from where they were measured.

namespace sightline {

struct UnevenTown {
  town::Town town = *town::make_town({3, 60.0});
  town::DriveSimulator drive;
  Drive recorded;
  Trajectory given;

  explicit UnevenTown(double length_m = 24.0) : drive(made(length_m)) {
    recorded = town::recorded(drive, "town", drive.disturbed_poses(), 0);
    for (const ScanInfo& scan : recorded.scans) {
      given.poses.push_back({scan.recording_index, scan.stamp_ns, *scan.T_world_vehicle});
    }
  }

 private:
  town::DriveSimulator made(double length_m) const {
    town::DriveOptions options = town::usual_drive(town.options, 0, *town::town_sensor(16));
    options.length_m = length_m;
    options.is_swept = true;
    options.sensor.azimuth_step_deg = 1.0;
    return *town::DriveSimulator::make(town, options);
  }
};

// Root mean square, beside what the scan's own pose is off.
inline double error_m(const UnevenTown& town, const Drive& straight) {
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

}  // namespace sightline

#pragma once

#include <algorithm>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/support/box_world.h"

// Box worlds measured by a sensor that turns while its vehicle drives, as real ones do, with files
// that do not say when each point was measured.

namespace sightline {

// In the order of time, or ring after ring, each from azimuth 0 to the left.
enum class PointOrder { kTime, kRings };

// Where the vehicle is at a time, s.
using VehicleMotion = std::function<Pose(double)>;

// Clockwise from behind, from half of `sweep_s` before the time to half behind it. 24 rings as
// scan_world; points as the sensor measured them, without times.
inline Scan sweep_world(const BoxWorld& world, const VehicleMotion& motion, double time_s,
                        PointOrder order, double sweep_s = 0.1) {
  constexpr double kRadians = std::numbers::pi / 180.0;
  constexpr int kColumns = 720;
  struct Seen {
    int ring = 0;
    double azimuth_deg = 0.0;
    Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  };
  std::vector<Seen> all;
  for (int column = 0; column < kColumns; ++column) {
    const double share = (column + 0.5) / kColumns;
    Pose T_map_lidar = motion(time_s + (share - 0.5) * sweep_s);
    T_map_lidar.translate(Eigen::Vector3d(0.0, 0.0, 2.0));
    const double azimuth_deg = share < 0.5 ? 180.0 - 360.0 * share : 540.0 - 360.0 * share;
    for (int ring = 0; ring < 24; ++ring) {
      const double e_rad = (-20.0 + 35.0 * ring / 23.0) * kRadians;
      const double a_rad = azimuth_deg * kRadians;
      const Eigen::Vector3d direction(std::cos(e_rad) * std::cos(a_rad),
                                      std::cos(e_rad) * std::sin(a_rad), std::sin(e_rad));
      const double range_m =
          world.cast(T_map_lidar.translation(), T_map_lidar.linear() * direction);
      if (range_m < 60.0) all.push_back({ring, azimuth_deg, range_m * direction});
    }
  }
  if (order == PointOrder::kRings) {
    std::ranges::sort(all, {},
                      [](const Seen& one) { return std::pair(one.ring, one.azimuth_deg); });
  }
  Scan scan;
  for (const Seen& one : all) scan.points_m.push_back(one.point_m);
  return scan;
}

// Scans at the given times. Their stamps are a tenth of a second apart, whatever the times are.
inline TestDrive drive_swept(const BoxWorld& world, const VehicleMotion& motion,
                             const std::vector<double>& times_s, PointOrder order,
                             double sweep_s = 0.1) {
  std::vector<Scan> scans;
  std::vector<Pose> poses;
  for (const double time_s : times_s) {
    scans.push_back(sweep_world(world, motion, time_s, order, sweep_s));
    poses.push_back(motion(time_s));
  }
  TestDrive result = drive_of(std::move(scans), poses);
  result.drive.sensor.azimuth_step_deg = 0.5;
  return result;
}

// Along x at so many m/s, winding to both sides so that heading turns by up to 20 degrees a second.
inline VehicleMotion winding(double from_m, double speed_mps) {
  return [=](double time_s) {
    const double x_m = from_m + speed_mps * time_s;
    const double per_m = 0.16;
    const double reach_m = 1.6;
    return pose_at(x_m, reach_m * std::sin(per_m * x_m),
                   std::atan(reach_m * per_m * std::cos(per_m * x_m)));
  };
}

}  // namespace sightline

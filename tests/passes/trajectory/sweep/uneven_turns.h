#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "formats/base/random.h"
#include "formats/drive/drive.h"
#include "tests/support/swept_world.h"

// A street driven by a vehicle that steers to and fro within a scan, with an inertial unit.

namespace sightline {

// Along x at 8 m/s; heading goes 1.5 degrees to both sides 3.5 times a second, so that it turns by
// up to 33 degrees a second one way and, 0.14 s later, the other; and it rolls a little.
inline Pose jerky(double time_s) {
  constexpr double kRadians = std::numbers::pi / 180.0;
  constexpr double kFull = 2.0 * std::numbers::pi;
  Pose pose = pose_at(-20.0 + 8.0 * time_s, 0.4 * std::sin(0.9 * time_s),
                      1.5 * kRadians * std::sin(kFull * 3.5 * time_s));
  pose.rotate(Eigen::AngleAxisd(0.4 * kRadians * std::sin(kFull * 2.2 * time_s + 1.0),
                                Eigen::Vector3d::UnitX()));
  return pose;
}

// How fast a motion turns about the vehicle's own axes, by poses 0.1 ms apart.
inline Eigen::Vector3d rate_of(const VehicleMotion& motion, double time_s) {
  constexpr double kStep_s = 1e-4;
  const Eigen::AngleAxisd turn(motion(time_s - 0.5 * kStep_s).linear().transpose() *
                               motion(time_s + 0.5 * kStep_s).linear());
  return turn.axis() * (turn.angle() / kStep_s);
}

struct ImuErrors {
  Eigen::Vector3d bias_radps = Eigen::Vector3d::Zero();
  double sigma_radps = 0.0;   // white, of each sample
  std::int64_t ahead_ns = 0;  // what its clock shows more
  std::int64_t step_ns = 5'000'000;
};

// From a second before time 0 to a second behind the last.
inline std::vector<TurnRate> imu_of(const VehicleMotion& motion, double last_s,
                                    const ImuErrors& errors = {}) {
  Random random(7);
  std::vector<TurnRate> rates;
  const auto end_ns = static_cast<std::int64_t>(1e9 * (last_s + 1.0));
  for (std::int64_t time_ns = -1'000'000'000; time_ns <= end_ns; time_ns += errors.step_ns) {
    Eigen::Vector3d rate = rate_of(motion, 1e-9 * static_cast<double>(time_ns)) + errors.bias_radps;
    for (double& axis : rate) axis += errors.sigma_radps * random.normal();
    rates.push_back({time_ns + errors.ahead_ns, rate});
  }
  return rates;
}

// The drive's scans with the times of their points, and the true poses.
inline TestDrive timed_drive(const BoxWorld& world, const VehicleMotion& motion, int scans) {
  std::vector<double> times_s;
  for (int i = 0; i < scans; ++i) times_s.push_back(0.1 * i);
  TestDrive test = drive_swept(world, motion, times_s, PointOrder::kTime);
  std::vector<Scan> timed;
  for (int i = 0; i < scans; ++i) {
    timed.push_back(*test.drive.store->read(static_cast<std::size_t>(i)));
    for (const Eigen::Vector3d& point_m : timed.back().points_m) {
      // The azimuth in the sensor's frame gives the time: clockwise from behind (sweep_world).
      const double azimuth_deg = std::atan2(point_m.y(), point_m.x()) * 180.0 / std::numbers::pi;
      const double share = (180.0 - azimuth_deg) / 360.0;
      timed.back().time_offset_ns.push_back(static_cast<std::int32_t>(1e8 * (share - 0.5)));
    }
    test.drive.scans[static_cast<std::size_t>(i)].has_point_times = true;
  }
  test.drive.store = memory_scan_store(std::move(timed));
  return test;
}

}  // namespace sightline

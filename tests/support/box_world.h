#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/random.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"

// Worlds of upright boxes on level ground, and drives through them with exact rays, small enough
// for tests of what scans are turned into.

namespace sightline {

struct TestBox {
  Eigen::Vector3d low_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d high_m = Eigen::Vector3d::Zero();
};

struct BoxWorld {
  std::vector<TestBox> boxes;

  // Distance to the first box or to the ground z = 0; infinity where there is neither.
  [[nodiscard]] double cast(const Eigen::Vector3d& origin_m,
                            const Eigen::Vector3d& direction) const {
    double nearest_m = std::numeric_limits<double>::infinity();
    if (direction.z() < 0.0) nearest_m = -origin_m.z() / direction.z();
    for (const TestBox& box : boxes) {
      double enter_m = 0.0;
      double leave_m = nearest_m;
      for (int axis = 0; axis < 3; ++axis) {
        const double a = (box.low_m[axis] - origin_m[axis]) / direction[axis];
        const double b = (box.high_m[axis] - origin_m[axis]) / direction[axis];
        enter_m = std::max(enter_m, std::min(a, b));
        leave_m = std::min(leave_m, std::max(a, b));
      }
      if (enter_m < leave_m) nearest_m = enter_m;
    }
    return nearest_m;
  }
};

// 24 rings from -20 to +15 degrees, a ray every azimuth step, no noise, to 60 m.
inline Scan scan_world(const BoxWorld& world, const Pose& T_map_lidar,
                       double azimuth_step_deg = 2.0) {
  constexpr double kRadians = std::numbers::pi / 180.0;
  Scan scan;
  for (int column = 0; column * azimuth_step_deg < 360.0; ++column) {
    for (int ring = 0; ring < 24; ++ring) {
      // Off by a little, so that no ray runs along a face.
      const double a_rad = (column * azimuth_step_deg + 0.123) * kRadians;
      const double e_rad = (-20.0 + 35.0 * ring / 23.0) * kRadians;
      const Eigen::Vector3d direction(std::cos(e_rad) * std::cos(a_rad),
                                      std::cos(e_rad) * std::sin(a_rad), std::sin(e_rad));
      const double range_m =
          world.cast(T_map_lidar.translation(), T_map_lidar.linear() * direction);
      if (range_m < 60.0) scan.points_m.push_back(range_m * direction);
    }
  }
  return scan;
}

inline Pose pose_at(double x_m, double y_m, double yaw_rad) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(x_m, y_m, 0.0);
  return pose;
}

// Of the sensor, 2 m above the vehicle's origin.
inline Pose lidar_at(double x_m, double y_m, double yaw_rad) {
  return Eigen::Translation3d(0.0, 0.0, 2.0) * pose_at(x_m, y_m, yaw_rad);
}

// Bare walls on both sides: scans do not show how far the vehicle moved.
inline BoxWorld bare_street() {
  return {{{{-200.0, 6.0, 0.0}, {200.0, 8.0, 6.0}}, {{-200.0, -8.0, 0.0}, {200.0, -6.0, 6.0}}}};
}

// A street along x: houses of differing depth and poles on the left, boxes of all sizes on the
// right.
inline BoxWorld random_street(std::uint64_t seed) {
  Random random(seed);
  BoxWorld world;
  for (double x_m = -40.0; x_m < 80.0; x_m += 6.0) {
    const double y_m = 8.0 + random.uniform(0.0, 4.0);
    world.boxes.push_back({{x_m, y_m, 0.0}, {x_m + random.uniform(3.0, 5.5), y_m + 4.0, 6.0}});
    const double pole_m = x_m + random.uniform(0.0, 5.0);
    world.boxes.push_back({{pole_m, 6.0, 0.0}, {pole_m + 0.3, 6.3, 5.0}});
    const double size_m = random.uniform(0.3, 3.0);
    const double right_m = -random.uniform(5.0, 9.0);
    world.boxes.push_back(
        {{x_m, right_m - size_m, 0.0}, {x_m + size_m, right_m, random.uniform(2.0, 5.0)}});
  }
  return world;
}

// Streets above each other, as storeys 2.75 m apart with ceilings of 2.5 m; the uppermost has a
// roof.
inline constexpr double kTestStorey_m = 2.75;
inline BoxWorld storeys_of(const std::vector<BoxWorld>& streets) {
  constexpr double kCeiling_m = 2.5;
  BoxWorld world;
  double floor_m = 0.0;
  for (const BoxWorld& street : streets) {
    for (TestBox box : street.boxes) {
      box.low_m.z() += floor_m;
      box.high_m.z() = floor_m + std::min(box.high_m.z(), kCeiling_m);
      world.boxes.push_back(box);
    }
    const double ceiling_m = floor_m + kCeiling_m;
    floor_m += kTestStorey_m;
    world.boxes.push_back({{-60.0, -15.0, ceiling_m}, {100.0, 15.0, floor_m}});
  }
  return world;
}

struct TestDrive {
  Drive drive;
  Trajectory truth;
};

// The sensor is 2 m above the vehicle's origin, which is on the ground; scans are a tenth of a
// second apart.
inline TestDrive drive_of(std::vector<Scan> scans, const std::vector<Pose>& T_map_vehicle) {
  TestDrive result;
  result.drive.name = "test";
  result.drive.sensor.beam_elevations_deg = {-20.0, 15.0};
  result.drive.sensor.T_vehicle_lidar.translation().z() = 2.0;
  for (std::uint32_t i = 0; i < scans.size(); ++i) {
    ScanInfo info;
    info.recording_index = i;
    info.stamp_ns = i * std::int64_t{100000000};
    info.point_count = scans[i].points_m.size();
    scans[i].stamp_ns = info.stamp_ns;
    result.drive.scans.push_back(info);
    result.truth.poses.push_back({i, info.stamp_ns, T_map_vehicle[i]});
  }
  result.drive.store = memory_scan_store(std::move(scans));
  return result;
}

inline TestDrive drive_through(const BoxWorld& world, const std::vector<Pose>& T_map_vehicle,
                               double azimuth_step_deg = 2.0) {
  Pose T_vehicle_lidar = Pose::Identity();
  T_vehicle_lidar.translation().z() = 2.0;
  std::vector<Scan> scans;
  for (const Pose& pose : T_map_vehicle)
    scans.push_back(scan_world(world, pose * T_vehicle_lidar, azimuth_step_deg));
  TestDrive result = drive_of(std::move(scans), T_map_vehicle);
  result.drive.sensor.azimuth_step_deg = azimuth_step_deg;
  return result;
}

inline std::vector<Scan> scans_of(const Drive& drive) {
  std::vector<Scan> scans;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) scans.push_back(*drive.store->read(i));
  return scans;
}

// The drive with returns that are off by Gaussian noise of so much along their rays.
inline void add_noise(double sigma_m, Random& random, TestDrive& test) {
  std::vector<Scan> scans = scans_of(test.drive);
  for (Scan& scan : scans) {
    for (Eigen::Vector3d& point_m : scan.points_m) {
      point_m *= 1.0 + sigma_m * random.normal() / point_m.norm();
    }
  }
  test.drive.store = memory_scan_store(std::move(scans));
}

inline TestDrive scaled(TestDrive test, double scale) {
  std::vector<Scan> scans = scans_of(test.drive);
  for (Scan& scan : scans) {
    for (Eigen::Vector3d& point_m : scan.points_m) point_m *= scale;
  }
  test.drive.store = memory_scan_store(std::move(scans));
  return test;
}

// Drives of a day each as one, in parts.
inline TestDrive joined_days(const std::vector<TestDrive>& days) {
  std::vector<Scan> scans;
  std::vector<Pose> poses;
  std::vector<std::uint32_t> parts;
  for (std::uint32_t day = 0; day < days.size(); ++day) {
    for (std::size_t i = 0; i < days[day].drive.scans.size(); ++i) {
      scans.push_back(*days[day].drive.store->read(i));
      scans.back().stamp_ns += day * std::int64_t{86'400'000'000'000};
      poses.push_back(days[day].truth.poses[i].T_map_vehicle);
      parts.push_back(day);
    }
  }
  TestDrive all = drive_of(scans, poses);
  all.drive.sensor = days.front().drive.sensor;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    all.drive.scans[i].part = parts[i];
    all.drive.scans[i].stamp_ns = all.truth.poses[i].stamp_ns = scans[i].stamp_ns;
  }
  for (std::size_t day = 1; day < days.size(); ++day) {
    all.drive.later_parts.push_back("day " + std::to_string(day + 1));
  }
  all.drive.store = memory_scan_store(std::move(scans));
  return all;
}

// Along x from `from_m` on, swinging a little to both sides.
inline std::vector<Pose> along_street(double from_m, std::size_t count, double step_m = 1.0) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const double x_m = from_m + step_m * static_cast<double>(i);
    poses.push_back(pose_at(x_m, 0.5 * std::sin(0.3 * x_m), 0.15 * std::cos(0.3 * x_m)));
  }
  return poses;
}

// The largest distance between two trajectories after the first poses are laid on each other.
inline double largest_error_m(const Trajectory& found, const Trajectory& truth) {
  const Pose T_truth_found = truth.poses[0].T_map_vehicle * found.poses[0].T_map_vehicle.inverse();
  double largest_m = 0.0;
  for (std::size_t i = 0; i < found.poses.size(); ++i) {
    const Pose laid = T_truth_found * found.poses[i].T_map_vehicle;
    const double error_m = (laid.translation() - truth.poses[i].T_map_vehicle.translation()).norm();
    largest_m = std::max(largest_m, error_m);
  }
  return largest_m;
}

}  // namespace sightline

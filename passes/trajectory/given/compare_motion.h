#pragma once

#include <cstdint>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/trajectory/following/odometry.h"

// Motion by given poses compared with motion by matching; part of estimate-trajectory. Poses are
// the sensor's: T_map_lidar.

namespace sightline {

// A motion from one scan to another, by given poses and by matching.
struct MotionPair {
  std::uint32_t from = 0;  // scans, by their place in the drive
  std::uint32_t to = 0;
  Pose given = Pose::Identity();  // T_from_to
  Pose matched = Pose::Identity();

  [[nodiscard]] double off_m() const;
  [[nodiscard]] double off_rad() const;
};
MotionPair motion_between(const GivenPoses& given, const Odometry& odometry, std::uint32_t from,
                          std::uint32_t to);

// Whether every scan after `from` up to `to` was matched to those before it.
bool is_matched_through(const Odometry& odometry, std::uint32_t from, std::uint32_t to);

// Whether the two scans contradict the given motion: by it, fewer upright returns of one meet the
// other's than by the matched motion. Along a wall without features, where matching slips, neither
// is contradicted; nor by scans that hardly overlap. Errors: those of reading a scan.
Result<bool> is_contradicted(const Drive& drive, const MotionPair& motion);

}  // namespace sightline

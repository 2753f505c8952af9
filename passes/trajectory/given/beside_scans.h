#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/trajectory/following/odometry.h"

// Given poses beside what the scans themselves show; part of estimate-trajectory. Poses here are
// the sensor's: T_map_lidar.

namespace sightline {

// A motion from one scan to another, as given and as matching found it.
struct MotionPair {
  std::uint32_t from = 0;  // scans, by their place in the drive
  std::uint32_t to = 0;
  Pose given = Pose::Identity();  // T_from_to
  Pose matched = Pose::Identity();

  [[nodiscard]] double off_m() const;
  [[nodiscard]] double off_rad() const;
};
MotionPair motion_between(const std::vector<std::optional<Pose>>& given, const Odometry& odometry,
                          std::uint32_t from, std::uint32_t to);

// Whether every scan after `from` up to `to` was matched to those before it.
bool is_matched_through(const Odometry& odometry, std::uint32_t from, std::uint32_t to);

// Whether the two scans speak for the matched motion and against the given one: by the share of
// upright returns of one that fall on the other's. A wall without features, along which matching
// slips, speaks for neither; nor do scans that hardly see the same things.
// Errors: what reading a scan says.
Result<bool> is_contradicted(const Drive& drive, const MotionPair& motion);

}  // namespace sightline

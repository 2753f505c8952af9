#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/trajectory/following/odometry.h"

// Where given poses move otherwise than matched scans; part of estimate-trajectory. Poses are the
// sensor's: T_map_lidar.

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
// Whether scans also constrained all motions of these steps: none is that of given poses.
bool is_constrained_through(const Odometry& odometry, std::uint32_t from, std::uint32_t to);

// What the two scans alone show of a motion: the share of the upright returns of one that meet the
// other's by each motion; none where there are too few.
struct MotionOverlaps {
  std::optional<double> given;
  std::optional<double> matched;

  // Fewer meet by the given motion. Along a wall without features, where matching slips, neither
  // motion is contradicted; nor by scans that hardly overlap.
  [[nodiscard]] bool contradict_given() const;
  [[nodiscard]] bool contradict_matched() const;  // more meet by the given motion
};
// Errors: those of reading a scan.
Result<MotionOverlaps> overlaps_of(const Drive& drive, const MotionPair& motion);

// A stretch on which given poses move otherwise than matched scans.
struct PoseDisagreement {
  std::uint32_t first = 0;  // scans, by their place in the drive
  std::uint32_t last = 0;
  double given_m = 0.0;  // how far the last one is from the first
  double matched_m = 0.0;
  double off_m = 0.0;  // the difference of the two motions
  double off_rad = 0.0;
  std::uint32_t worst = 0;  // the scan that is off most, relative to the first
  double worst_off_m = 0.0;
};

// Compares motions over about 3 m of way: 0.15 m and 5 % of the way, or 1 degree and 5 % of the
// turn, are allowed. Stretches that touch are one. Left out are scans without a given pose, those
// that could not be matched, and motions that the scans do not contradict (MotionOverlaps), unless
// they are off by 1 m and 25 % of the way and scans do not contradict the matched motion instead.
// Errors: those of reading a scan.
Result<std::vector<PoseDisagreement>> find_disagreements(const Drive& drive,
                                                         const GivenPoses& given,
                                                         const Odometry& odometry);

std::string to_text(const PoseDisagreement& disagreement, const Drive& drive);

// Scans whose given poses are not where the other given poses and matching put them.
struct PoseJump {
  std::uint32_t first = 0;  // scans, by their place in the drive
  std::uint32_t last = 0;
  std::uint32_t worst = 0;
  double off_m = 0.0;  // of the worst one
  double off_rad = 0.0;
};

struct JumpLimits {
  double off_m = 1.5;
  double off_rad = 0.1;
};

// Given poses are cut where from one to the next they move otherwise than matched scans by more
// than the limits and a tenth of the motion, and the scans contradict that (MotionOverlaps). The
// longest part is kept, and each further part that is where odometry leads from the nearest kept
// one; the others are jumps. Ascending. Errors: those of reading a scan.
Result<std::vector<PoseJump>> find_jumps(const Drive& drive, const JumpLimits& limits,
                                         const GivenPoses& given, const Odometry& odometry);

// "scans 30 to 35 ... (file)": the scans, and how far off they are.
std::string to_text(const PoseJump& jump, const Drive& drive);

}  // namespace sightline

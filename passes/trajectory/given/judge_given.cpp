#include "passes/trajectory/given/judge_given.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "formats/base/portable_math.h"
#include "passes/trajectory/local/first_places.h"

namespace sightline {
namespace {

Error refused(const std::string& text, const Drive& drive, std::uint32_t scan) {
  const ScanInfo& worst = drive.scans[scan];
  return {ErrorCode::kMismatchedInputs, text, worst.source,
          "scan " + std::to_string(worst.recording_index)};
}

std::size_t poses_of(const std::vector<PoseJump>& jumps) {
  std::size_t count = 0;
  for (const PoseJump& jump : jumps) count += jump.last - jump.first + 1;
  return count;
}

}  // namespace

Result<GivenVerdict> judge_given(const Drive& drive, const JumpLimits& limits,
                                 const GivenPoses& given, const Odometry& odometry) {
  GivenVerdict verdict;
  SIGHTLINE_ASSIGN(verdict.jumps, find_jumps(drive, limits, given, odometry));
  SIGHTLINE_ASSIGN(verdict.disagreements,
                   find_disagreements(drive, without_jumps(given, verdict.jumps), odometry));
  return verdict;
}

GivenPoses without_jumps(GivenPoses given, const std::vector<PoseJump>& jumps) {
  for (const PoseJump& jump : jumps) {
    for (std::uint32_t k = jump.first; k <= jump.last; ++k) given[k].reset();
  }
  return given;
}

std::string jumps_text(const std::vector<PoseJump>& jumps, const Drive& drive) {
  return with_first_places("the scans contradict " + std::to_string(poses_of(jumps)) + " of " +
                               std::to_string(drive.scans.size()) + " given poses of drive " +
                               drive.name,
                           jumps, drive);
}

std::string disagreements_text(const std::vector<PoseDisagreement>& found, const Drive& drive) {
  return with_first_places("given poses and scans disagree on " + std::to_string(found.size()) +
                               " stretches of drive " + drive.name,
                           found, drive);
}

std::string sharpening_text(const Sharpening& found, const std::vector<WayStretch>& stretches,
                            const Drive& drive) {
  const auto off = [](const WayStretch& stretch) {
    return stretch.off_rad + portable_hypot(stretch.along_m, stretch.aside_m);
  };
  const WayStretch& worst = *std::ranges::max_element(stretches, {}, off);
  char text[320];
  std::snprintf(text, sizeof text,
                "given poses of drive %s are refined: on %td of %zu stretches of 50 m they move "
                "otherwise than the scans (over 10 m by %.2f m and %.2f degrees at scans %u to %u) "
                "and blur the map (mean entropy %.3f nat, refined %.3f); "
                "estimate-trajectory.mode=given keeps them",
                drive.name.c_str(), std::ranges::count_if(stretches, is_doubtful), stretches.size(),
                portable_hypot(worst.along_m, worst.aside_m),
                worst.off_rad * 180.0 / std::numbers::pi, drive.scans[worst.first].recording_index,
                drive.scans[worst.last].recording_index, found.given.entropy_nat,
                found.refined.entropy_nat);
  return text;
}

Error refused_jumps(const std::vector<PoseJump>& jumps, const Drive& drive) {
  const auto worst = std::ranges::max_element(jumps, {}, &PoseJump::off_m);
  std::string text = jumps_text(jumps, drive);
  if (2 * poses_of(jumps) > drive.scans.size()) {
    text +=
        ". So many: look at the columns, the axes and the order of the poses, and at "
        "lidar_yaw_deg";
  }
  return refused(text + ". estimate-trajectory.bad_poses=repair goes on without them", drive,
                 worst->worst);
}

Error refused_disagreements(const std::vector<PoseDisagreement>& found, const Drive& drive) {
  return refused(disagreements_text(found, drive), drive, found.front().first);
}

}  // namespace sightline

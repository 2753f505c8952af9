#include "passes/trajectory/given/jumps.h"

#include <algorithm>
#include <cstdio>
#include <numbers>

#include "formats/geometry.h"
#include "passes/trajectory/given/compare_motion.h"

namespace sightline {
namespace {

// Share of the motion and of the turn: a wrong scale is a disagreement, not a jump at every scan.
constexpr double kAllowedShare = 0.1;
// No drive goes so far between two scans, whether they can be matched or not.
constexpr double kFarthestStep_m = 10'000.0;

// Scans with given poses that move as the scans do.
using Part = std::vector<std::uint32_t>;

class JumpFinder {
 public:
  JumpFinder(const Drive& drive, const JumpLimits& limits, const GivenPoses& given,
             const Odometry& odometry)
      : drive_(drive), limits_(limits), given_(given), odometry_(odometry) {}

  Result<std::vector<PoseJump>> run() const {
    SIGHTLINE_ASSIGN(const std::vector<Part> parts, cut());
    std::vector<PoseJump> jumps;
    if (parts.size() < 2) return jumps;
    const auto longest = std::ranges::max_element(parts, {}, &Part::size);
    std::uint32_t anchor = longest->front();
    for (auto part = longest; part != parts.begin();) {
      --part;
      visit(*part, part->back(), part->front(), anchor, jumps);
    }
    std::ranges::reverse(jumps);
    anchor = longest->back();
    for (auto part = longest + 1; part != parts.end(); ++part) {
      visit(*part, part->front(), part->back(), anchor, jumps);
    }
    return joined(jumps);
  }

 private:
  [[nodiscard]] bool is_far(const MotionPair& motion) const {
    const double way_m = odometry_.driven_m[std::max(motion.from, motion.to)] -
                         odometry_.driven_m[std::min(motion.from, motion.to)];
    return motion.off_m() > limits_.off_m + kAllowedShare * way_m ||
           motion.off_rad() >
               limits_.off_rad + kAllowedShare * rotation_angle_rad(motion.matched.linear()) ||
           motion.given.translation().norm() > kFarthestStep_m;
  }

  [[nodiscard]] Result<bool> is_cut(std::uint32_t before, std::uint32_t after) const {
    const MotionPair step = motion_between(given_, odometry_, before, after);
    if (step.given.translation().norm() > kFarthestStep_m) return true;
    if (!is_far(step) || !is_matched_through(odometry_, before, after)) return false;
    return is_contradicted(drive_, step);
  }

  [[nodiscard]] Result<std::vector<Part>> cut() const {
    std::vector<Part> parts;
    for (std::uint32_t k = 0; k < given_.size(); ++k) {
      if (!given_[k]) continue;
      bool begins = parts.empty();
      if (!begins) {
        SIGHTLINE_ASSIGN(begins, is_cut(parts.back().back(), k));
      }
      if (begins) parts.emplace_back();
      parts.back().push_back(k);
    }
    return parts;
  }

  // Keeps the part, which is then the anchor of the next one, or adds a jump. `near` and `far` are
  // its scans next to the anchor and farthest from it.
  void visit(const Part& part, std::uint32_t near, std::uint32_t far, std::uint32_t& anchor,
             std::vector<PoseJump>& jumps) const {
    if (!is_far(motion_between(given_, odometry_, anchor, near))) {
      anchor = far;
      return;
    }
    PoseJump& jump = jumps.emplace_back(PoseJump{part.front(), part.back(), near});
    for (const std::uint32_t scan : part) {
      const MotionPair motion = motion_between(given_, odometry_, anchor, scan);
      if (scan != part.front() && motion.off_m() <= jump.off_m) continue;
      jump.worst = scan;
      jump.off_m = motion.off_m();
      jump.off_rad = motion.off_rad();
    }
  }

  // Jumps that follow each other as one.
  [[nodiscard]] std::vector<PoseJump> joined(const std::vector<PoseJump>& jumps) const {
    std::vector<PoseJump> all;
    for (const PoseJump& jump : jumps) {
      const bool follows =
          !all.empty() &&
          std::none_of(given_.begin() + all.back().last + 1, given_.begin() + jump.first,
                       [](const std::optional<Pose>& pose) { return pose.has_value(); });
      if (!follows) {
        all.push_back(jump);
        continue;
      }
      const std::uint32_t first = all.back().first;
      if (jump.off_m > all.back().off_m) all.back() = jump;
      all.back().first = first;
      all.back().last = jump.last;
    }
    return all;
  }

  const Drive& drive_;
  const JumpLimits& limits_;
  const GivenPoses& given_;
  const Odometry& odometry_;
};

}  // namespace

Result<std::vector<PoseJump>> find_jumps(const Drive& drive, const JumpLimits& limits,
                                         const GivenPoses& given, const Odometry& odometry) {
  return JumpFinder(drive, limits, given, odometry).run();
}

std::string to_text(const PoseJump& jump, const Drive& drive) {
  const ScanInfo& worst = drive.scans[jump.worst];
  const std::string file = worst.source.empty() ? "" : " (" + worst.source + ")";
  char off[96];
  std::snprintf(off, sizeof off, "%.2f m and %.1f degrees", jump.off_m,
                jump.off_rad * 180.0 / std::numbers::pi);
  const std::string lies = std::string(" lies ") + off + " from where the scans put it";
  if (jump.first == jump.last) {
    return "scan " + std::to_string(worst.recording_index) + file + lies;
  }
  return "scans " + std::to_string(drive.scans[jump.first].recording_index) + " to " +
         std::to_string(drive.scans[jump.last].recording_index) + ", of which scan " +
         std::to_string(worst.recording_index) + file + lies;
}

}  // namespace sightline

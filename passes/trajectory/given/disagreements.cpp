#include "passes/trajectory/given/disagreements.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "formats/geometry.h"
#include "passes/trajectory/local/local_map.h"

namespace sightline {
namespace {

// Long enough for an error of speed to rise above the noise of a good receiver.
constexpr double kWindow_m = 3.0;
constexpr std::size_t kMostScans = 20;
constexpr double kAllowed_m = 0.15;
constexpr double kAllowedShare = 0.05;
// Matching slips along a wall without features, but not so far.
constexpr double kLongestSlip_m = 1.0;
constexpr double kLongestSlipShare = 0.25;
constexpr double kAllowed_rad = 1.0 * std::numbers::pi / 180.0;

PoseDisagreement compare(const GivenPoses& given, const Odometry& odometry, std::uint32_t first,
                         std::uint32_t last) {
  const MotionPair motion = motion_between(given, odometry, first, last);
  PoseDisagreement found{first, last, motion.given.translation().norm(),
                         motion.matched.translation().norm()};
  found.off_m = motion.off_m();
  found.off_rad = motion.off_rad();
  for (std::uint32_t k = first + 1; k <= last; ++k) {
    if (!given[k]) continue;
    const double off_m = motion_between(given, odometry, first, k).off_m();
    if (off_m <= found.worst_off_m) continue;
    found.worst = k;
    found.worst_off_m = off_m;
  }
  return found;
}

bool is_bad(const MotionPair& motion) {
  return motion.off_m() > kAllowed_m + kAllowedShare * motion.matched.translation().norm() ||
         motion.off_rad() >
             kAllowed_rad + kAllowedShare * rotation_angle_rad(motion.matched.linear());
}

bool is_gross(const MotionPair& motion) {
  return motion.off_m() > kLongestSlip_m + kLongestSlipShare * motion.matched.translation().norm();
}

// Overlap of upright returns; scans of one street have 0.65 and more.
constexpr double kLeastOverlap = 0.35;
// A contradicted motion has less than this share of the other one's overlap.
constexpr double kContradictedShare = 0.9;

// Share of the motion and of the turn: a wrong scale is a disagreement, not a jump at every scan.
constexpr double kJumpShare = 0.1;
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
    return motion.off_m() > limits_.off_m + kJumpShare * way_m ||
           motion.off_rad() >
               limits_.off_rad + kJumpShare * rotation_angle_rad(motion.matched.linear()) ||
           motion.given.translation().norm() > kFarthestStep_m;
  }

  [[nodiscard]] Result<bool> is_cut(std::uint32_t before, std::uint32_t after) const {
    const MotionPair step = motion_between(given_, odometry_, before, after);
    if (step.given.translation().norm() > kFarthestStep_m) return true;
    if (!is_far(step) || !is_matched_through(odometry_, before, after)) return false;
    SIGHTLINE_ASSIGN(const MotionOverlaps overlaps, overlaps_of(drive_, step));
    return overlaps.contradict_given();
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

double MotionPair::off_m() const { return (given.translation() - matched.translation()).norm(); }

double MotionPair::off_rad() const {
  return rotation_angle_rad(matched.linear().transpose() * given.linear());
}

MotionPair motion_between(const GivenPoses& given, const Odometry& odometry, std::uint32_t from,
                          std::uint32_t to) {
  return {from, to, given[from]->inverse() * *given[to],
          odometry.T_map_lidar[from].inverse() * odometry.T_map_lidar[to]};
}

bool is_matched_through(const Odometry& odometry, std::uint32_t from, std::uint32_t to) {
  const auto scan = odometry.is_matched.begin();
  return std::find(scan + from + 1, scan + to + 1, false) == scan + to + 1;
}

bool is_constrained_through(const Odometry& odometry, std::uint32_t from, std::uint32_t to) {
  const auto step = odometry.constraint.begin();
  return is_matched_through(odometry, from, to) &&
         std::all_of(step + from + 1, step + to + 1,
                     [](const StepConstraint& one) { return one.forecast_motions.isZero(0.0); });
}

bool MotionOverlaps::contradict_given() const {
  if (!matched || *matched < kLeastOverlap) return false;
  return given.value_or(0.0) < kContradictedShare * *matched;
}

bool MotionOverlaps::contradict_matched() const {
  return given && matched && *matched < kContradictedShare * *given;
}

Result<MotionOverlaps> overlaps_of(const Drive& drive, const MotionPair& motion) {
  const Eigen::Matrix3d level = drive.sensor.T_vehicle_lidar.linear();
  SIGHTLINE_ASSIGN(const ThinnedScan from, read_thinned(drive, motion.from, ThinnedFor::kMap));
  SIGHTLINE_ASSIGN(const ThinnedScan to, read_thinned(drive, motion.to, ThinnedFor::kMatch));
  UprightMap seen(1.0);
  seen.add(upright_points(from.to_map_m, level), Pose::Identity(), 0.0);
  const std::vector<Eigen::Vector3d> upright_m = upright_points(to.to_match_m, level);
  return MotionOverlaps{seen.overlap(upright_m, motion.given),
                        seen.overlap(upright_m, motion.matched)};
}

Result<std::vector<PoseDisagreement>> find_disagreements(const Drive& drive,
                                                         const GivenPoses& given,
                                                         const Odometry& odometry) {
  std::vector<PoseDisagreement> stretches;
  std::uint32_t last = 0;
  for (std::uint32_t first = 0; first + 1 < given.size(); ++first) {
    last = std::max(last, first);
    const auto is_long = [&] {
      return odometry.driven_m[last] - odometry.driven_m[first] >= kWindow_m ||
             last - first >= kMostScans;
    };
    while (last + 1 < given.size() && !is_long()) ++last;
    if (!given[first] || !given[last] || last == first) continue;
    if (!is_matched_through(odometry, first, last)) continue;
    const MotionPair motion = motion_between(given, odometry, first, last);
    if (!is_bad(motion)) continue;
    SIGHTLINE_ASSIGN(const MotionOverlaps overlaps, overlaps_of(drive, motion));
    const bool is_wrong =
        overlaps.contradict_given() || (is_gross(motion) && !overlaps.contradict_matched());
    if (!is_wrong) continue;
    if (stretches.empty() || stretches.back().last < first) {
      stretches.push_back(compare(given, odometry, first, last));
    } else {
      stretches.back() = compare(given, odometry, stretches.back().first, last);
    }
  }
  return stretches;
}

std::string to_text(const PoseDisagreement& found, const Drive& drive) {
  return fmt::format(
      "scans {} to {}: the given poses move {:.2f} m, the scans {:.2f} m; the motions differ by "
      "{:.2f} m and {:.1f} degrees, most at scan {} ({:.2f} m)",
      drive.scans[found.first].recording_index, drive.scans[found.last].recording_index,
      found.given_m, found.matched_m, found.off_m, found.off_rad * 180.0 / std::numbers::pi,
      drive.scans[found.worst].recording_index, found.worst_off_m);
}

Result<std::vector<PoseJump>> find_jumps(const Drive& drive, const JumpLimits& limits,
                                         const GivenPoses& given, const Odometry& odometry) {
  return JumpFinder(drive, limits, given, odometry).run();
}

std::string to_text(const PoseJump& jump, const Drive& drive) {
  const ScanInfo& worst = drive.scans[jump.worst];
  const std::string off = fmt::format(
      "scan {}{} is {:.2f} m and {:.1f} degrees from the pose that matching finds",
      worst.recording_index, worst.source.empty() ? "" : concat(" (", worst.source, ")"),
      jump.off_m, jump.off_rad * 180.0 / std::numbers::pi);
  if (jump.first == jump.last) return off;
  return fmt::format("scans {} to {}, of which {}", drive.scans[jump.first].recording_index,
                     drive.scans[jump.last].recording_index, off);
}

}  // namespace sightline

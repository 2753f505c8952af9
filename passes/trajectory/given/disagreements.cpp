#include "passes/trajectory/given/disagreements.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "formats/geometry.h"
#include "passes/trajectory/given/compare_motion.h"

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

}  // namespace

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
    SIGHTLINE_ASSIGN(const bool is_wrong, is_contradicted(drive, motion));
    if (!is_wrong && !is_gross(motion)) continue;
    if (stretches.empty() || stretches.back().last < first) {
      stretches.push_back(compare(given, odometry, first, last));
    } else {
      stretches.back() = compare(given, odometry, stretches.back().first, last);
    }
  }
  return stretches;
}

std::string to_text(const PoseDisagreement& found, const Drive& drive) {
  char text[256];
  std::snprintf(text, sizeof text,
                "scans %u to %u: given poses move %.2f m, the scans show %.2f m; they are %.2f m "
                "and %.1f degrees apart, scan %u most (%.2f m)",
                drive.scans[found.first].recording_index, drive.scans[found.last].recording_index,
                found.given_m, found.matched_m, found.off_m,
                found.off_rad * 180.0 / std::numbers::pi, drive.scans[found.worst].recording_index,
                found.worst_off_m);
  return text;
}

}  // namespace sightline

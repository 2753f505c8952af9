#include "passes/trajectory/given/disagreements.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "formats/rotation.h"

namespace sightline {
namespace {

// Long enough for an error of speed to rise above the noise of a good receiver.
constexpr double kWindow_m = 3.0;
constexpr std::size_t kMostScans = 20;
constexpr double kAllowed_m = 0.15;
constexpr double kAllowedShare = 0.05;
constexpr double kAllowed_rad = 1.0 * std::numbers::pi / 180.0;

PoseDisagreement compare(const std::vector<std::optional<Pose>>& given, const Odometry& odometry,
                         std::uint32_t first, std::uint32_t last) {
  const Pose by_given = given[first]->inverse() * *given[last];
  const Pose by_match = odometry.T_map_lidar[first].inverse() * odometry.T_map_lidar[last];
  PoseDisagreement found{first, last, by_given.translation().norm(), by_match.translation().norm()};
  found.off_m = (by_given.translation() - by_match.translation()).norm();
  found.off_rad = rotation_angle_rad((by_match.inverse() * by_given).linear());
  return found;
}

bool is_bad(const PoseDisagreement& found, double turned_rad) {
  return found.off_m > kAllowed_m + kAllowedShare * found.matched_m ||
         found.off_rad > kAllowed_rad + kAllowedShare * turned_rad;
}

}  // namespace

std::vector<PoseDisagreement> find_disagreements(const std::vector<std::optional<Pose>>& given,
                                                 const Odometry& odometry) {
  std::vector<PoseDisagreement> stretches;
  std::uint32_t last = 0;
  for (std::uint32_t first = 0; first + 1 < given.size(); ++first) {
    last = std::max(last, first);
    const auto is_long = [&] {
      return odometry.driven_m[last] - odometry.driven_m[first] >= kWindow_m ||
             last - first >= kMostScans;
    };
    bool is_known = given[first].has_value();
    for (std::uint32_t k = first + 1; k <= last; ++k) is_known = is_known && odometry.is_matched[k];
    while (last + 1 < given.size() && !is_long()) {
      ++last;
      is_known = is_known && odometry.is_matched[last];
    }
    if (!is_known || !given[last] || last == first) continue;
    const PoseDisagreement found = compare(given, odometry, first, last);
    const Pose by_match = odometry.T_map_lidar[first].inverse() * odometry.T_map_lidar[last];
    if (!is_bad(found, rotation_angle_rad(by_match.linear()))) continue;
    if (stretches.empty() || stretches.back().last < first) {
      stretches.push_back(found);
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
                "and %.1f degrees apart",
                drive.scans[found.first].recording_index, drive.scans[found.last].recording_index,
                found.given_m, found.matched_m, found.off_m,
                found.off_rad * 180.0 / std::numbers::pi);
  return text;
}

}  // namespace sightline

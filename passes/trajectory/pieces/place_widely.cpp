#include "passes/trajectory/pieces/place_widely.h"

#include <algorithm>
#include <numbers>

#include "formats/rotation.h"

namespace sightline {
namespace {

constexpr double kElsewhere_m = 1.0;
constexpr double kElsewhere_rad = 5.0 * std::numbers::pi / 180.0;

struct Candidate {
  LocalMatch match;
  double overlap = 0.0;
};

}  // namespace

bool are_elsewhere(const Pose& a, const Pose& b) {
  const Pose between = a.inverse() * b;
  return between.translation().norm() > kElsewhere_m ||
         rotation_angle_rad(between.linear()) > kElsewhere_rad;
}

std::optional<WidePlacement> place_widely(const LocalSurroundings& there, const SoughtScan& scan,
                                          const Pose& T_map_around,
                                          const WideSearch& options) {
  std::vector<Candidate> candidates;
  for (const WiderStart& start :
       wider_starts(there.upright.points_m(), scan.upright_m, T_map_around, options)) {
    const LocalMatch match = match_locally(there.grids, scan.to_match_m, start.T_map_lidar);
    if (!match.is_good()) continue;
    const std::optional<double> overlap = there.upright.overlap(scan.upright_m, match.T_map_lidar);
    if (overlap) candidates.push_back({match, *overlap});
  }
  if (candidates.empty()) return std::nullopt;
  const auto best = std::ranges::max_element(candidates, {}, &Candidate::overlap);
  WidePlacement placement{best->match, best->overlap, 0.0};
  for (const Candidate& other : candidates) {
    if (!are_elsewhere(other.match.T_map_lidar, best->match.T_map_lidar)) continue;
    placement.overlap_elsewhere = std::max(placement.overlap_elsewhere, other.overlap);
  }
  return placement;
}

}  // namespace sightline

#pragma once

#include <optional>
#include <vector>

#include "passes/trajectory/local/local_map.h"
#include "passes/trajectory/local/local_match.h"
#include "passes/trajectory/local/wider_starts.h"

namespace sightline {

// A local map: NDs for matching, upright points for the overlap.
struct LocalSurroundings {
  const LocalGrids& grids;
  const UprightMap& upright;
};

// A scan that is looked for.
struct SoughtScan {
  const std::vector<Eigen::Vector3d>& to_match_m;
  const std::vector<Eigen::Vector3d>& upright_m;  // of those, for the overlap
};

struct WidePlacement {
  LocalMatch match;
  double overlap = 0.0;
  // Of the best place more than a match's error away: a place is known only where no other is
  // nearly as good.
  double overlap_elsewhere = 0.0;
};

// Searches all headings and up to the reach around; each of the best starts is matched. None where
// no start ends in a good match.
std::optional<WidePlacement> place_widely(const LocalSurroundings& there, const SoughtScan& scan,
                                          const Pose& T_map_around, const WideSearch& options);

// Matches the scan from given places at headings up to 100 degrees to either side, for a vehicle
// that turned quickly where it was. The first of the places whose overlap is within 0.03 of the
// largest. None where no start ends in a good match.
std::optional<WidePlacement> place_turned(const LocalSurroundings& there, const SoughtScan& scan,
                                          const std::vector<Pose>& T_map_places);

// Whether two poses of one scan are different places.
bool are_elsewhere(const Pose& a, const Pose& b);

}  // namespace sightline

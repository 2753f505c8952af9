#pragma once

#include <vector>

#include "formats/annotation/sites.h"
#include "formats/geometry.h"
#include "passes/trajectory/following/followed_scans.h"

namespace sightline {

// Moves a piece of a drive that is found nowhere in a map to where no site and no other scan is, 2
// km beyond along x. Part of align-drive.
void separate_piece(const std::vector<Pose>& T_own_lidar, const ScanRange& piece,
                    const Sites& sites, std::vector<Pose>& T_map_lidar);

}  // namespace sightline

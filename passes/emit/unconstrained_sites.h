#pragma once

#include <vector>

#include "formats/annotation/site_column.h"
#include "formats/annotation/sites.h"
#include "formats/drive/trajectory.h"
#include "formats/drive/unconstrained_stretches.h"

// Which sites are where scans do not constrain the poses of the map; part of emit-map.

namespace sightline {

// By the pose nearest to each site, at most 10 m away: "pose_sigma_m", the standard deviation of
// the position in the unconstrained directions since these began (inf: not known; -inf: the pose is
// constrained, or given), and "unconstrained", the sum of 1 (along the road), 2 (across it) and 4
// (in heading). No column where every pose is constrained.
std::vector<SiteColumn> unconstrained_columns(const Trajectory& trajectory, const Sites& sites);

}  // namespace sightline

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "formats/geometry.h"

namespace sightline {

struct WideSearch {
  double reach_m = 45.0;     // in the plane, along each axis
  double least_share = 0.3;  // of a start; less is met by chance in many streets
  std::size_t most_starts = 8;
  // Half a cell at the end of the farthest point; fewer take less time, and a match turns the rest.
  int headings = 504;
  // To which the scan is thinned, below 256: enough to distinguish places of one street.
  std::size_t most_points = 240;
};

struct WiderStart {
  Pose T_map_lidar = Pose::Identity();
  double share = 0.0;  // of the scan's upright points that meet the map's, in cells of 0.5 m
};

// Poses at all headings and up to the reach around `T_map_around` whose upright points
// fall on those of the map, the best first; poses within 1.5 m and 10 degrees of a better one are
// left out. Height, roll and pitch are those of `T_map_around`. Exhaustive on cells of 0.5 m by
// branch and bound (Hess et al., "Real-time loop closure in 2D LIDAR SLAM", 2016), with a bound on
// the work, after which the best so far are returned. The same order on every machine.
std::vector<WiderStart> wider_starts(const std::vector<Eigen::Vector3d>& map_upright_m,
                                     const std::vector<Eigen::Vector3d>& scan_upright_m,
                                     const Pose& T_map_around, const WideSearch& options);

}  // namespace sightline

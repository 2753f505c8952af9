#pragma once

#include <cstddef>
#include <vector>

#include "formats/surroundings/surface_points.h"

namespace sightline {

// What stood still, thinned to one centroid in each cubic voxel of leaf_m (0: every point), in map
// coordinates; ascending by voxel (x, y, z), points of 0 in their own order. Errors: what reading a
// scan says, bad-value (a leaf below 0).
Result<std::vector<Eigen::Vector3d>> thinned_points(const SurfacePoints& surface, double leaf_m);

// PLY of points (binary, double x y z), as they are.
std::vector<std::byte> points_ply(const std::vector<Eigen::Vector3d>& points_m);

}  // namespace sightline

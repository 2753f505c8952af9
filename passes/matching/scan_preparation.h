#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace sightline {

// The points at slant range |x| <= range, in their order. Sensor frame.
std::vector<Eigen::Vector3d> crop(std::span<const Eigen::Vector3d> points_m, double range_m);

// One centroid for each voxel floor(x / leaf) that holds a point, ascending by voxel key (x, then
// y, then z). Points must be finite and within 2^31 voxels of the origin.
std::vector<Eigen::Vector3d> voxel_subsample(std::span<const Eigen::Vector3d> points_m,
                                             double leaf_m);

}  // namespace sightline

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "formats/ndt_map.h"

namespace sightline {

// The cells between two corners, both of them inside.
struct VoxelBox {
  CellKey low;
  CellKey high;
};

// Voxels whose box has at most so many cells are worth a table: a million bits and four million bytes,
// of which a scan touches few.
inline constexpr double kMostTableCells = 1 << 20;
double cell_count(const VoxelBox& box);

// One centroid for each voxel that holds a point, ascending by key: the points of a voxel are added in
// their order. Every point's key, floor(x / leaf), must lie in the box, whose cells may be
// kMostTableCells at most.
std::vector<Eigen::Vector3d> centroids_by_table(std::span<const Eigen::Vector3d> points_m,
                                                double leaf_m, const VoxelBox& box);

}  // namespace sightline

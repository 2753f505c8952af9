#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "formats/surroundings/ndt_map.h"

namespace sightline::static_50m {

// The cells between two corners, both of them inside.
struct VoxelBox {
  CellKey low;
  CellKey high;
};

// Voxels whose box has at most so many cells are worth a table: a million bits and four million
// bytes, of which a scan touches few.
inline constexpr double kMostTableCells = 1 << 20;
double cell_count(const VoxelBox& box);

// The voxels of one scan after another: it keeps its memory from one to the next.
class VoxelTable {
 public:
  // An empty table of the cells of `box`, which may be kMostTableCells at most.
  void begin(const VoxelBox& box);

  // Adds points to their voxels, in their order: a point's key, floor(x / leaf), must lie in the
  // box.
  void add(std::span<const Eigen::Vector3d> points_m, double leaf_m);

  // One centroid for each voxel that holds a point, ascending by key. The table is then empty.
  std::vector<Eigen::Vector3d> take_centroids_m();

 private:
  struct Voxel {
    Eigen::Vector3d sum_m;
    double count;
  };

  void add_keyed(std::span<const Eigen::Vector3d> points_m, std::span<const CellKey> keys);

  CellKey low_;
  std::int64_t y_width_ = 0;
  std::int64_t z_width_ = 0;
  std::vector<std::uint64_t> bits_;           // of cells: is there a voxel?
  std::vector<std::uint64_t> words_;          // of words of bits_: is any of them set?
  std::unique_ptr<std::uint32_t[]> numbers_;  // of voxels, where there is one
  std::size_t number_count_ = 0;
  std::vector<Voxel> voxels_;  // the first `voxel_count_`, in the order in which they were met
  std::uint32_t voxel_count_ = 0;
};

}  // namespace sightline::static_50m

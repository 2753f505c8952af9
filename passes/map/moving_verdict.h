#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/grid/flat_cell_map.h"

namespace sightline {

// What the scans say of one voxel.
struct SeenVoxel {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  std::uint32_t point_count = 0;
  std::uint32_t hits = 0;    // scans with a return in it
  std::uint32_t misses = 0;  // scans that looked through it
  std::uint32_t last_scan = 0;
  bool is_ground = false;
  float above_ground_m = 0.0F;  // of the ground of its surroundings; below 0: beneath it

  [[nodiscard]] Eigen::Vector3d mean_m() const { return sum_m / point_count; }
};

// The voxels with returns of one place. Free space is not stored: memory grows with the surface
// alone.
using SeenVoxels = FlatCellMap<SeenVoxel>;

// Evidence for standing, by OctoMap's sensor model: log odds of hits and misses. Below 0: it moved.
double log_odds(const SeenVoxel& voxel);

// Whether a voxel stands beyond doubt even if every one of `scan_count` scans that did not hit it
// looks through it: no ray need be asked.
bool stands_anyway(const SeenVoxel& voxel, std::size_t scan_count);

// Farthest that one voxel's verdict depends on others, m.
double reach_of_judgement_m(double voxel_m);

// Fills is_ground and above_ground_m. Ground is what lies within a hand's breadth of the lowest
// return of its surroundings; what lies beneath the level that the surroundings have in common is a
// mirror image in wet or polished ground and does not count.
void mark_ground(SeenVoxels& seen);

// The voxels at most `steps` away on each axis, without itself.
std::vector<std::uint32_t> neighbours(const SeenVoxels& seen, std::size_t v, int steps);

// One a voxel: 1 where it moved.
std::vector<std::uint8_t> judge(const SeenVoxels& seen);

}  // namespace sightline

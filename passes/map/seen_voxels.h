#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "formats/grid/cell_index.h"

namespace sightline {

// What the scans say of one voxel.
struct SeenVoxel {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  std::uint32_t point_count = 0;
  std::uint32_t hits = 0;    // scans with a return in it
  std::uint32_t misses = 0;  // scans that looked through it
  std::uint32_t last_scan = 0;
  // Log odds of the drives that saw it, where there are several, in place of those of hits and
  // misses (drive_evidence.h).
  std::optional<double> of_drives_log_odds = {};
  bool has_changed = false;  // stood beyond doubt on an earlier drive, the latest look through it
  bool is_ground = false;
  bool is_level = false;        // goes on level all around, with nothing on it
  float above_ground_m = 0.0F;  // of the ground of its surroundings; below 0: beneath it

  [[nodiscard]] Eigen::Vector3d mean_m() const { return sum_m / point_count; }
};

// The voxels with returns of one place. Free space is not stored.
using SeenVoxels = CellTable<SeenVoxel>;

// Columns of the plane, 3 x 3 voxels each, as one number, so that the neighbour of a column is a
// sum away: column_of(key) + column_number(1, 0).
std::int64_t column_number(std::int64_t x, std::int64_t y);
std::int64_t column_of(const CellKey& key);

// How many voxels away the ground below one is looked for.
std::int32_t reach_of_ground_voxels();

// Fills is_ground, is_level and above_ground_m. Ground is what lies within 0.15 m of the lowest
// return of its surroundings, and a level surface up to 0.5 m above it on which nothing stands.
// What lies beneath the common level of the surroundings is a mirror image and does not count.
void mark_ground(SeenVoxels& seen);

}  // namespace sightline

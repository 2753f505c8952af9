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

// The voxels with returns of one place. Free space is not stored: memory grows with the surface
// alone.
using SeenVoxels = CellTable<SeenVoxel>;

}  // namespace sightline

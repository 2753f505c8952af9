#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "formats/geometry.h"
#include "formats/grid/cell_key.h"
#include "passes/map/drive_evidence.h"
#include "passes/map/scan_rays.h"
#include "passes/map/seen_voxels.h"

namespace sightline {

// The square of the plane of a key.
Eigen::AlignedBox2d box_of(const TileKey& key, double edge_m);

struct LookOptions {
  double voxel_m = 0.2;
  double range_m = 60.0;  // no scan looks farther
};

// How many scans may look into a box, of each part of the drive.
using ScansNear = std::function<std::vector<std::size_t>(const Eigen::AlignedBox2d& box)>;

// One scan that looks at the voxels.
struct LookingScan {
  std::uint32_t number = 0;  // of the scan; each looks once
  std::uint32_t part = 0;    // of the drive
  const Pose& T_map_lidar;
  const ScanRays& rays;
  std::span<const std::uint32_t> hit_voxels;
};

// Voxels that scans may look through: all but those that stand in any case. Part of remove-moving.
//
// Carving by voxels alone removes ground, walls and poles that rays graze. So a scan contradicts a
// voxel only when one of its rays
// - passes near the centre of the voxel's own points, not anywhere through the voxel;
// - goes on well beyond it;
// - and, where the voxel is the lowest of its place, passes below its points: ground stays;
// and when the scan hit nothing that stands above the ground in a neighbouring voxel.
// Near the ground rays that end beneath it are ignored: wet or polished ground mirrors.
//
// Refers to what was seen, its ground marked, and to the evidence of several drives (or nullptr).
class AskedVoxels {
 public:
  AskedVoxels(const LookOptions& options, SeenVoxels& seen, DriveEvidence* of_drives,
              const ScansNear& scans_near);

  // Counts what the scan contradicts.
  void look(const LookingScan& scan);
  // Writes the misses into the voxels seen.
  void conclude();

  // Rays that come as near as this to the middle of a voxel's points pass through them.
  static double touch_m(double voxel_m);

 private:
  // A voxel, apart from the table of all; these are walked once a scan.
  struct Asked {
    Eigen::Vector3d mean_m;
    float above_ground_m;
    bool is_ground;
    std::uint32_t number;
    std::uint32_t misses = 0;
    // What stands above the ground and touches it: a stretch of touching_.
    std::size_t touching_begin = 0;
    std::size_t touching_end = 0;
  };

  // Voxels that share one answer to whether they are near a sensor.
  struct Column {
    Eigen::AlignedBox2d box;
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    Eigen::Vector3d anchor_m = Eigen::Vector3d::Zero();
    float radius_m = 0.0F;
  };

  // The means of voxels from the anchors of their columns.
  struct Places {
    std::vector<float> x_m, y_m, z_m;

    // Adds one, and makes the column reach it.
    void add(const Eigen::Vector3d& mean_m, Column& column);
    [[nodiscard]] RayPlaces of(const Column& column) const;
  };

  void choose(const ScansNear& scans_near);
  [[nodiscard]] bool stands_anyway_here(std::uint32_t voxel,
                                        const std::vector<std::size_t>& scan_counts) const;
  void gather_neighbours();
  void look_into(const Column& column, const LookingScan& scan);
  [[nodiscard]] bool is_spared(const Asked& voxel, std::uint32_t scan) const;
  [[nodiscard]] bool looks_through(const LookingScan& scan, const Asked& voxel) const;

  LookOptions options_;
  SeenVoxels& seen_;
  DriveEvidence* of_drives_;
  std::vector<Column> columns_;
  std::vector<Asked> asked_;             // by column
  Places places_;                        // of these
  std::vector<std::uint32_t> touching_;  // see Asked
  std::vector<std::uint32_t> hit_by_;    // of each voxel: the last scan that hit it and looked
  std::vector<std::uint32_t> passable_;  // of a column; kept for its memory
};

}  // namespace sightline

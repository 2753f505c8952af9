#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "passes/matching/voxel_table.h"

namespace sightline {

// How a vehicle's scan becomes the points that are matched.
struct ScanCut {
  double range_m = 0.0;  // 3D slant range from the sensor
  double leaf_m = 1.0;   // voxel grid in the sensor's frame
  // As the paper does; else what lies denser than voxels need is left out (return_stride).
  bool takes_every_return = false;
};

// A sensor turns by the same angle between two returns wherever they lie, so near ones are denser
// than any voxel needs. The longest stride that leaves neighbours on a ring a quarter of a voxel
// apart at the range, or nearer ("Measured error" in schemas/definitions.md): a whole number plus
// (sqrt(5) - 1) / 2, or else 1. Returns come ring by ring in turn, and a step that is near no
// fraction meets all rings alike. 1 where every return is taken.
double return_stride(const ScanCut& cut, double azimuth_step_deg);

// Cuts one scan after another and keeps its memory from one to the next. One thread at a time.
class ScanCutter {
 public:
  // Of the returns number floor(n stride), n = 0, 1, .., those at slant range |x| <= range are put
  // into voxels floor(x / leaf): one centroid for each that holds any, ascending by voxel key (x,
  // then y, then z). Sensor frame. At stride 1 these are voxel_subsample(crop(points, range),
  // leaf), to the bit. Points must be finite, range and leaf above 0, the stride at least 1.
  std::vector<Eigen::Vector3d> cut(std::span<const Eigen::Vector3d> points_m, const ScanCut& cut,
                                   double stride);

 private:
  VoxelTable voxels_;
};

}  // namespace sightline

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/drive/drive.h"
#include "passes/matching/voxel_table.h"

namespace sightline {

// How a vehicle's scan becomes the points that are matched.
struct ScanCut {
  double range_m = 0.0;  // 3D slant range from the sensor
  double leaf_m = 1.0;   // voxel grid in the sensor's frame
  // As the paper does; else what lies denser than voxels need is left out (return_stride).
  bool takes_every_return = false;
};

// The longest stride up to `longest` of this kind: a whole number plus (sqrt(5) - 1) / 2, or
// else 1. Returns come ring by ring in turn, and a step that is near no fraction meets all rings
// alike.
double even_stride(double longest);

// The longest stride, as even_stride() has it, that leaves neighbours on a ring at most a quarter
// of a voxel apart at the range ("Measured error" in schemas/definitions.md). 1 where every return
// is taken.
double return_stride(const ScanCut& cut, double azimuth_step_deg);

// Keeps its memory from one scan to the next. One thread at a time.
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

// Numbers of the filters of Autoware's ndt_scan_matcher, as it comes: crop box, voxel grid, random
// downsampling.
struct AutowareFilters {
  double box_m = 60.0;  // around the vehicle, to each side
  double voxel_m = 3.0;
  std::size_t most_points = 1500;
  double range_m = 200.0;  // slant range from the sensor: Autoware has none, this contains its box
  friend bool operator==(const AutowareFilters&, const AutowareFilters&) = default;
};

// A scan as Autoware's filters leave it for its NDT ("Localizers" in schemas/definitions.md,
// `pcl-ndt`). Keeps its memory from one scan to the next; one thread at a time.
class AutowareSampler {
 public:
  static constexpr double kBoxBelow_m = 30.0;
  static constexpr double kBoxAbove_m = 50.0;

  // Of the returns within range and box one centroid for each voxel floor(x / voxel_m); of more
  // than most_points as many at random, which depends on the seed alone. Vehicle frame; by voxel
  // key (x, then y, then z) where all are taken. The box is at most 60 m.
  std::vector<Eigen::Vector3d> sample(const Scan& scan, const SensorProfile& sensor,
                                      const AutowareFilters& filters, std::uint64_t seed);

 private:
  std::vector<Eigen::Vector3d> in_box_m_;
  ScanCutter cutter_;
};

}  // namespace sightline

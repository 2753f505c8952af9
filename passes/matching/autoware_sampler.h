#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/drive/drive.h"
#include "passes/matching/scan_cutter.h"

namespace sightline {

// A scan as Autoware's filters leave it for its NDT ("Localizers" in schemas/definitions.md,
// `pcl-ndt`). Keeps its memory from one scan to the next; one thread at a time.
class AutowareSampler {
 public:
  static constexpr double kBox_m = 60.0;  // around the vehicle, to each side
  static constexpr double kBoxBelow_m = 30.0;
  static constexpr double kBoxAbove_m = 50.0;
  static constexpr double kVoxel_m = 3.0;
  static constexpr std::size_t kMostPoints = 1500;
  static constexpr double kNoLimit_m = 200.0;  // a range that holds the whole box

  // Of the returns at slant range <= range_m and in the box one centroid for each voxel
  // floor(x / 3 m); of more than 1500 as many at random, which depends on the seed alone. Vehicle
  // frame; by voxel key (x, then y, then z) where all are taken.
  std::vector<Eigen::Vector3d> sample(const Scan& scan, const SensorProfile& sensor, double range_m,
                                      std::uint64_t seed);

 private:
  std::vector<Eigen::Vector3d> in_box_m_;
  ScanCutter cutter_;
};

}  // namespace sightline

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/recording/recording.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// The pose whose quaternion has the same four numbers read as w x y z instead of x y z w.
Pose read_w_first(const Pose& pose);

// Poses of `drive` (those of `recording`) are read as w x y z where the scans contradict them as x
// y z w and not so, with a warning that says it: where that lays scans on each other far better, or
// turns a vehicle on its feet whose ground was above it. Of a file of quaternions with a pose for
// every scan; up to twelve scans are read. Errors: those of read_recorded_scan.
Result<void> try_w_first(PassContext& ctx, const Recording& recording, Drive& drive);

// Pairs of scans by which poses that came with a recording are judged, before anything is matched.

struct ScanPair {
  std::size_t first = 0;
  std::size_t second = 0;
};

// Up to six pairs, spread over the recording, 2 to 10 m apart, so that much of what one sees the
// other sees too. Every scan has a pose.
std::vector<ScanPair> choose_pairs(const Recording& recording);

// The returns 3 to 30 m away and more than half a metre above the ground `height_m` below the
// sensor: ground lies on ground under any yaw.
std::vector<Eigen::Vector3d> upright_returns(const PointCloudFile& cloud, double height_m);

// Share of `second` that falls into a voxel of half a metre that holds a point of `first`.
double share_that_falls_on(const std::vector<Eigen::Vector3d>& first,
                           const std::vector<Eigen::Vector3d>& second, const Pose& T_first_second);

}  // namespace sightline

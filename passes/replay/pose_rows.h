#pragma once

#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "passes/vehicle/c_values.h"
#include "passes/vehicle/vehicle_localizer.h"

// Poses and scans as the vehicle's library takes them.

namespace sightline {

inline PoseRows rows_of(const Pose& pose) {
  PoseRows rows{};
  put_pose(pose, rows.data());
  return rows;
}

// Refers to the scan.
inline sightline_points points_of(const Scan& scan) {
  return {scan.points_m.data(), scan.points_m.size(), sizeof(Eigen::Vector3d), 1};
}

inline bool has_matched(const sightline_match& match) {
  return match.stop != SIGHTLINE_NO_POINTS && match.stop != SIGHTLINE_NO_OVERLAP;
}

}  // namespace sightline

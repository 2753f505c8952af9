#pragma once

#include "formats/foreign/clouds/points/point_cloud_file.h"

namespace sightline {

// Adds a return to the cloud and is true; counts a point that is not a return, and is false.
inline bool add_point(PointCloudFile& cloud, const Eigen::Vector3d& point_m, float intensity) {
  if (!point_m.allFinite()) {
    ++cloud.nonfinite_count;
    return false;
  }
  if (point_m.isZero(0.0)) {
    ++cloud.zero_count;
    return false;
  }
  cloud.points_m.push_back(point_m);
  cloud.intensity.push_back(intensity);
  return true;
}

}  // namespace sightline

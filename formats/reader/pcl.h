#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Core>
#include <cstdint>

#include "formats/reader/reader.h"

// For vehicles that work with PCL: header only, of the target sightline::reader_pcl
// (find_package(sightline REQUIRED COMPONENTS pcl)). Nothing else of the reader knows PCL.

namespace sightline {

// The points of a scan that a vehicle uses where the map gave `answer`: those at most
// answer.range_m from the sensor, along the ray and not along the ground, as the error was measured
// with; in their order, all fields kept. The cloud is in metres, in any frame in which the sensor
// lies at `sensor_m` (zero: the sensor's own). Points that are not finite go, so the result is
// dense; it is one row, with the header and the sensor's pose of the scan.
template <class PointT>
pcl::PointCloud<PointT> crop(const pcl::PointCloud<PointT>& scan, const RangeAnswer& answer,
                             const Eigen::Vector3d& sensor_m = Eigen::Vector3d::Zero()) {
  const double range2_m2 = answer.range_m * answer.range_m;
  pcl::PointCloud<PointT> cropped;
  for (const PointT& point : scan) {
    const Eigen::Vector3d from_sensor_m = Eigen::Vector3d(point.x, point.y, point.z) - sensor_m;
    // Not true of a coordinate that is NaN or infinite.
    if (from_sensor_m.squaredNorm() <= range2_m2) cropped.points.push_back(point);
  }
  cropped.header = scan.header;
  cropped.width = static_cast<std::uint32_t>(cropped.points.size());
  cropped.height = 1;
  cropped.is_dense = true;
  cropped.sensor_origin_ = scan.sensor_origin_;
  cropped.sensor_orientation_ = scan.sensor_orientation_;
  return cropped;
}

}  // namespace sightline

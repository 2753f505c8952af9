#pragma once

#include <cstdint>

#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"

// A place without a drive, as a site.

namespace sightline {

// Height of the vehicle's origin where it stands on the ground.
inline double vehicle_above_ground_m(const SensorProfile& sensor) {
  return sensor.height_m - sensor.T_vehicle_lidar.translation().z();
}

// The vehicle's origin is at vehicle_map_m, it stands level and looks along `heading` (of unit
// length, in the plane).
inline Site level_site(std::uint32_t run, double s_m, const Eigen::Vector3d& vehicle_map_m,
                       const Eigen::Vector2d& heading, const SensorProfile& sensor) {
  Site site;
  site.run = run;
  site.s_m = s_m;
  site.T_map_vehicle.linear().col(0) << heading.x(), heading.y(), 0.0;
  site.T_map_vehicle.linear().col(1) << -heading.y(), heading.x(), 0.0;
  site.T_map_vehicle.translation() = vehicle_map_m;
  site.p_map_m = (site.T_map_vehicle * sensor.T_vehicle_lidar).translation();
  return site;
}

}  // namespace sightline

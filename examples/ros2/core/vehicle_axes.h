#pragma once

#include <cstdint>
#include <string>

#include "poses.h"

namespace sightline_ros2 {

struct VehicleSigmas {
  double forward_m = 0.0;
  double left_m = 0.0;
  double yaw_rad = 0.0;  // about the vertical of the map
};
VehicleSigmas sigmas_of(const Pose& T_map_base, const Covariance& covariance);

// Of a covariance whose position is along the vehicle's axes; turns stay as they are.
Covariance in_map_axes(const Pose& T_map_base, const Covariance& of_vehicle);

// "forward, yaw" of SIGHTLINE_WEAK_*; "none".
std::string names_of_weak(std::uint32_t weak);

}  // namespace sightline_ros2

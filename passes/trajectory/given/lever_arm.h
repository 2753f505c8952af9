#pragma once

#include <Eigen/Core>
#include <optional>

#include "formats/drive/drive.h"
#include "passes/trajectory/following/odometry.h"

namespace sightline {

// How far the sensor is from where T_vehicle_lidar puts it, m, in the vehicle's axes, by given and
// matched motions over about 10 m that scans constrain: a sensor that is `a` from there moves by
// (R - I) a otherwise while the vehicle turns by R. A direction about which the vehicle did not
// turn enough is 0. None where that explains less than half of the differences, or is below 0.2 m.
std::optional<Eigen::Vector3d> lever_arm_m(const Drive& drive, const GivenPoses& given,
                                           const Odometry& odometry);

}  // namespace sightline

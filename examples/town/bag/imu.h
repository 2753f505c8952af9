#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "examples/town/drive/drive.h"
#include "formats/drive/drive.h"
#include "formats/geometry.h"

namespace sightline::town {

// What an inertial unit in the car measures during a drive that is swept, 200 times a second from
// half a second before it to half a second behind it, about the axes of the vehicle's frame: each
// rate is off by a bias of up to 0.01 rad/s on each axis and by white noise of 0.003 rad/s, as one
// of a few hundred euros is.
std::vector<TurnRate> imu_of(const DriveSimulator& drive, std::uint64_t seed);

// Where the unit sits: on its side, its y axis is up, its x axis ahead.
Pose T_vehicle_imu();

// The specific force (acceleration less gravity, m/s2) at each of those times, about the axes of
// the unit: off by a bias of up to 0.05 m/s2 on each axis and by white noise of 0.03 m/s2.
std::vector<Eigen::Vector3d> specific_forces(const DriveSimulator& drive, std::uint64_t seed,
                                             const std::vector<TurnRate>& rates);

// What the wheels measure 50 times a second from the first scan to the last: the speed along the
// vehicle's x axis, with a scale that is off by up to 1.5 % during the whole drive and white noise
// of 0.02 m/s; and the turn rate by their difference, with white noise of 0.02 rad/s.
struct WheelSpeed {
  std::int64_t stamp_ns = 0;
  double speed_m_s = 0.0;
  double yaw_rate_rad_s = 0.0;
};
std::vector<WheelSpeed> wheel_speeds(const DriveSimulator& drive, std::uint64_t seed);

}  // namespace sightline::town

#pragma once

#include <cstdint>
#include <vector>

#include "examples/town/drive/drive.h"
#include "formats/drive/drive.h"

namespace sightline::town {

// What an inertial unit in the car measures during a drive that is swept, 200 times a second from
// half a second before it to half a second behind it, about the axes of the vehicle's frame: each
// rate is off by a bias of up to 0.01 rad/s on each axis and by white noise of 0.003 rad/s, as one
// of a few hundred euros is.
std::vector<TurnRate> imu_of(const DriveSimulator& drive, std::uint64_t seed);

}  // namespace sightline::town

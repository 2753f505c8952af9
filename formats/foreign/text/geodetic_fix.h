#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/geodesy.h"

namespace sightline {

// A pose of a satellite receiver or an inertial unit. Angles as ROS has them (REP 103):
// x forward, y left, z up; yaw from east, counter-clockwise; pitch positive with the nose down.
struct GeodeticFix {
  std::optional<std::int64_t> stamp_ns;
  Geodetic at;
  std::optional<double> yaw_rad;
  double pitch_rad = 0.0;
  double roll_rad = 0.0;
};

struct GeodeticTrack {
  std::vector<GeodeticFix> fixes;     // times ascend where there are any
  std::vector<std::string> warnings;  // what was skipped or assumed
};

}  // namespace sightline

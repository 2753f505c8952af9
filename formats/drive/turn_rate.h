#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "formats/record/fields.h"

namespace sightline {

// How fast a vehicle turned at one time, as an inertial unit measured it: about the axes of the
// vehicle's frame, rad/s. The clock is that of the scans' stamps.
struct TurnRate {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d rate_rad_per_s = Eigen::Vector3d::Zero();
};
SIGHTLINE_FIELDS(TurnRate, stamp_ns, rate_rad_per_s)

}  // namespace sightline

#pragma once

#include "formats/geometry.h"

namespace sightline {

// Where a vehicle will be that moves on evenly. `motion` is its last one, in its own frame
// (T_before_last); `factor` is the time until then over the time which that took.
inline Pose predicted_pose(const Pose& T_map_last, const Pose& motion, double factor = 1.0) {
  const AxisAngle turn = axis_angle(motion.linear());
  Pose onwards = Pose::Identity();
  onwards.linear() = rotation_matrix({turn.axis, factor * turn.angle_rad});
  onwards.translation() = factor * motion.translation();
  return T_map_last * onwards;
}

}  // namespace sightline

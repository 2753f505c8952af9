#include "passes/matching/foretold_pose.h"

#include "formats/rotation.h"

namespace sightline {

Pose foretold_pose(const Pose& T_map_last, const Pose& motion, double factor) {
  const AxisAngle turn = axis_angle(motion.linear());
  Pose onwards = Pose::Identity();
  onwards.linear() = rotation_matrix({turn.axis, factor * turn.angle_rad});
  onwards.translation() = factor * motion.translation();
  return T_map_last * onwards;
}

}  // namespace sightline

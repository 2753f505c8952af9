#pragma once

#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/geometry.h"

namespace sightline {

// Where the matcher is started, relative to the reference ("Measured error" in
// schemas/definitions.md, v1): in a disc, each start turned and lifted a little.
struct StartPattern {
  int count = 12;
  double radius_m = 1.0;
  double yaw_deg = 1.0;  // the most
  double z_m = 0.1;      // the most
};
std::vector<InitialOffset> initial_offsets(const StartPattern& pattern);

// T_reference_start.
Pose start_pose(const InitialOffset& offset);

// Where a vehicle will be after its last motion (T_before_last) times `factor`.
inline Pose predicted_pose(const Pose& T_map_last, const Pose& motion, double factor = 1.0) {
  const AxisAngle turn = axis_angle(motion.linear());
  Pose onwards = Pose::Identity();
  onwards.linear() = rotation_matrix({turn.axis, factor * turn.angle_rad});
  onwards.translation() = factor * motion.translation();
  return T_map_last * onwards;
}

}  // namespace sightline

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

}  // namespace sightline

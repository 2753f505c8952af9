#pragma once

#include "passes/factors/virtual/information.h"

namespace sightline {

// How far off the pose may be by the Cramer-Rao bound of the samples, with the prior of
// schemas/definitions.md (10 m, 10 degrees). It takes samples as independent: it ranks places, it
// is no accuracy.
struct Crlb {
  double max_m = 0.0;        // along the weakest horizontal direction
  double min_m = 0.0;        // along the strongest
  double heading_deg = 0.0;  // of the weakest, counter-clockwise from map +x, in [0, 180)
  double yaw_rad = 0.0;
};
Crlb crlb(const Matrix6d& information);

// Along a horizontal line of this heading, degrees from map +x, m: between min_m and max_m.
double std_along_m(const Crlb& bound, double heading_deg);

}  // namespace sightline

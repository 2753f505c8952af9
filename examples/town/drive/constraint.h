#pragma once

#include "examples/town/drive/drive.h"

// What a scan constrains in truth: rays without noise against the exact surfaces, what moves left
// out.

namespace sightline::town {

// Along the vehicle's axes: ahead and to the left.
struct Constraint {
  // The share of a start's error of 0.3 m that is left after matching the scan, point to plane, to
  // the true surfaces: near 0 where the direction is constrained, near 1 where it is not. A
  // direction is unconstrained where it is more than a half.
  double kept_ahead = 0.0;
  double kept_left = 0.0;
  // The standard deviation that range noise of 2 cm leaves at best, m; 99 at most. Points count as
  // independent, so it is a lower bound.
  double sigma_ahead_m = 0.0;
  double sigma_left_m = 0.0;
};

// About a quarter of the rays are used. Takes some tenths of a second. Safe from several threads.
Constraint constraint_of(const DriveSimulator& drive, std::size_t index);

}  // namespace sightline::town

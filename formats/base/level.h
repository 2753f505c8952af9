#pragma once

#include <cmath>

// The level of a place: a storey of a car park, a road on a bridge or the one below it.

namespace sightline {

// Sensors at two places on one level differ in height by less than this. Storeys are twice as far
// apart; a visit of the same road by another vehicle, or with an error of a receiver, is nearer.
inline constexpr double kLevelHeight_m = 1.0;

// Whether two heights, m, of sensors at places near each other are on one level.
inline bool is_same_level(double a_z_m, double b_z_m) {
  return std::abs(a_z_m - b_z_m) < kLevelHeight_m;
}

}  // namespace sightline

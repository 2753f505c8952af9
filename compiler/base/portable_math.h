#pragma once

namespace sightline {

// Functions whose last bit differs between C libraries, and even between processors with one
// library; here made of operations that IEEE 754 rounds correctly, so that results reach the same
// bits everywhere. Errors are a few units in the last place.

struct SinCos {
  double sin = 0.0;
  double cos = 1.0;
};
SinCos portable_sin_cos(double angle_rad);  // of at most 1e5 rad in size

double portable_atan2(double y, double x);  // finite; 0 at the origin

double portable_log(double x);  // of a positive, normal x

}  // namespace sightline

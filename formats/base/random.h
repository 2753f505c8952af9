#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "formats/base/portable_math.h"

namespace sightline {

// SplitMix64 (Steele, Lea, Flood 2014). The same numbers on every machine and library, which the
// distributions of <random> do not promise. Seed it with mix(ctx.seed, key of the unit of work).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  // Uniform in [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  // Uniform in [0, count); 0 < count < 2^32, so that the bias stays below 2^-21.
  std::uint64_t below(std::uint64_t count) {
    return static_cast<std::uint64_t>(uniform() * static_cast<double>(count));
  }
  // Standard normal, by Box and Muller; two uniforms a call, no state kept between calls.
  double normal() {
    const double u = 1.0 - uniform();
    const double v = uniform();
    return std::sqrt(-2.0 * portable_log(u)) * portable_sin_cos(2.0 * std::numbers::pi * v).cos;
  }

 private:
  std::uint64_t state_;
};

// A seed for one unit of work, far from the seeds of its neighbours.
inline std::uint64_t mix(std::uint64_t seed, std::uint64_t key) {
  return Random(seed ^ Random(key).next()).next();
}

}  // namespace sightline

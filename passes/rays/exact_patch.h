#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "formats/surroundings/surface.h"

// Where a ray meets a patch, decided in double; part of surface_caster.

namespace sightline {

inline constexpr double kNotHit_m = std::numeric_limits<double>::infinity();
// Of a ray to the plane of a patch, as a sine (0.6 degrees): what is seen more edge-on is not hit.
inline constexpr double kLeastSlope = 0.01;

// A patch as doubles see it, in two lines of the cache.
struct alignas(64) ExactPatch {
  Eigen::Vector3d centre_m, normal, side, other_side;
  double half_side_m = 0.0;
  std::uint64_t solid = 0;
};

inline ExactPatch exact_patch(const SurfacePatch& patch) {
  const Eigen::Vector3d side = side_of(patch);
  return {patch.centre_m,           patch.normal,      side,
          patch.normal.cross(side), patch.half_side_m, patch.solid};
}

// What is solid of a patch lies between these places along its sides, in halves of a side from its
// centre.
struct SolidBounds {
  double low_along, high_along;
  double low_across, high_across;
};

// Of one solid square or more.
inline SolidBounds bounds_of_solid(std::uint64_t solid) {
  static_assert(kPatchSquares == 8, "a row of square_at() is a byte");
  std::uint64_t columns = solid | solid >> 32;
  columns |= columns >> 16;
  columns = (columns | columns >> 8) & 0xFF;
  const auto edge = [](int square) { return square * (2.0 / kPatchSquares) - 1.0; };
  return {edge(std::countr_zero(columns)), edge(64 - std::countl_zero(columns)),
          edge(std::countr_zero(solid) / kPatchSquares),
          edge((63 - std::countl_zero(solid)) / kPatchSquares + 1)};
}

// A patch as seen from the place where rays begin.
struct SeenPatch {
  const ExactPatch& patch;
  double ahead_m, aside_m, other_aside_m;  // of its centre, along its normal and its sides

  SeenPatch(const ExactPatch& seen, const Eigen::Vector3d& p_m) : patch(seen) {
    const Eigen::Vector3d to_centre_m = patch.centre_m - p_m;
    ahead_m = patch.normal.dot(to_centre_m);
    aside_m = patch.side.dot(to_centre_m);
    other_aside_m = patch.other_side.dot(to_centre_m);
  }
  // At which a ray meets it; +inf where it does not, or hardly turns towards it.
  [[nodiscard]] double distance_m(const Eigen::Vector3d& direction) const {
    const double slope = patch.normal.dot(direction);
    if (std::abs(slope) < kLeastSlope) return kNotHit_m;
    const double distance_m = ahead_m / slope;
    const double off_m = distance_m * patch.side.dot(direction) - aside_m;
    const double other_off_m = distance_m * patch.other_side.dot(direction) - other_aside_m;
    const bool is_inside =
        std::abs(off_m) <= patch.half_side_m && std::abs(other_off_m) <= patch.half_side_m;
    if (!is_inside) return kNotHit_m;
    const int square = square_at(off_m / patch.half_side_m, other_off_m / patch.half_side_m);
    return (patch.solid >> square & 1) != 0 ? distance_m : kNotHit_m;
  }
};

}  // namespace sightline

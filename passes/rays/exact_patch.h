#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "formats/surroundings/surface.h"

// Where a ray meets a patch, decided in double; part of surface_caster.

namespace sightline {

inline constexpr double kNotHit_m = std::numeric_limits<double>::infinity();
// Of a ray to the plane of a patch, as a sine (0.6 degrees): what is seen more edge-on is not hit.
inline constexpr double kLeastSlope = 0.01;

// A patch as doubles see it.
struct ExactPatch {
  Eigen::Vector3d centre_m, normal, side, other_side;
  double half_side_m = 0.0;
  std::uint64_t solid = 0;
};

inline ExactPatch exact_patch(const SurfacePatch& patch) {
  const Eigen::Vector3d side = side_of(patch);
  return {patch.centre_m,           patch.normal,      side,
          patch.normal.cross(side), patch.half_side_m, patch.solid};
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

#pragma once

#include <Eigen/Core>

#include "formats/surroundings/surface.h"

namespace sightline {

inline constexpr int kSquaresOfPatch = kPatchSquares * kPatchSquares;
// A return farther from a plane, as a share of the patch's half side, is no part of it.
inline constexpr double kMostOffPlane = 0.3;

// A patch with its axes at hand.
struct PatchPlane {
  Eigen::Vector3d centre_m, normal, side, other_side;
  double half_side_m = 0.0;

  explicit PatchPlane(const SurfacePatch& patch);
  // The square across which a place lies; -1 beside the patch.
  [[nodiscard]] int square_of(const Eigen::Vector3d& place_m) const;
  // The same for a return; -1 also for one that is no part of the patch.
  [[nodiscard]] int square_of_return(const Eigen::Vector3d& place_m) const;
  [[nodiscard]] Eigen::Vector3d middle_m(int square) const;
};

}  // namespace sightline

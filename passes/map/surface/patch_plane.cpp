#include "passes/map/surface/patch_plane.h"

#include <Eigen/Geometry>
#include <cmath>

namespace sightline {

PatchPlane::PatchPlane(const SurfacePatch& patch)
    : centre_m(patch.centre_m),
      normal(patch.normal),
      side(side_of(patch)),
      other_side(patch.normal.cross(side)),
      half_side_m(patch.half_side_m) {}

int PatchPlane::square_of(const Eigen::Vector3d& place_m) const {
  const Eigen::Vector3d from_centre_m = place_m - centre_m;
  const double along_m = side.dot(from_centre_m);
  const double across_m = other_side.dot(from_centre_m);
  if (std::abs(along_m) > half_side_m || std::abs(across_m) > half_side_m) return -1;
  return square_at(along_m / half_side_m, across_m / half_side_m);
}

int PatchPlane::square_of_return(const Eigen::Vector3d& place_m) const {
  const double off_m = normal.dot(place_m - centre_m);
  return std::abs(off_m) > kMostOffPlane * half_side_m ? -1 : square_of(place_m);
}

Eigen::Vector3d PatchPlane::middle_m(int square) const {
  const double step_m = 2.0 * half_side_m / kPatchSquares;
  const double column = square % kPatchSquares + 0.5 - 0.5 * kPatchSquares;
  const int rows_before = square / kPatchSquares;
  const double row = rows_before + 0.5 - 0.5 * kPatchSquares;
  return centre_m + step_m * (column * side + row * other_side);
}

}  // namespace sightline

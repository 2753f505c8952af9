#include "passes/map/surface/patch_lanes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

// Of a lane, as a share of the largest number that it is computed from.
constexpr double kLost = 16.0 * 0x1.0p-24;

}  // namespace

// Each lane sums four terms, none larger than `scale` times the sum of the box's edges and what it
// is at the patch itself. Of each term three numbers are rounded, and of the sums three, by 2^-24
// of them: less than 10 of these in all.
PatchLanes::PatchLanes(std::span<const PatchPlane> planes, const Eigen::AlignedBox3d& box_m) {
  constexpr double kMiddle = 0.5 * kPatchSquares;
  if (planes.empty()) return;
  middle_m_ = box_m.center();
  edges_m_ = box_m.sizes().sum();
  lanes_.reserve(planes.size());
  for (const PatchPlane& plane : planes) {
    const Eigen::Vector3d normal = plane.normal * (0.5 / (kMostOffPlane * plane.half_side_m));
    const Eigen::Vector3d column = plane.side * (kMiddle / plane.half_side_m);
    const Eigen::Vector3d row = plane.other_side * (kMiddle / plane.half_side_m);
    const Eigen::Vector3d from_centre_m = middle_m_ - plane.centre_m;
    const double slack = kLost * (kMiddle / plane.half_side_m * edges_m_ + kPatchSquares);
    // Off the plane by the same as beside, in metres; farther off along a ray by the slope.
    slack_m_ = std::max(slack_m_, slack * plane.half_side_m / kMiddle / kLeastSlope);
    const auto floats = [](double a, double b, double c, double d) {
      return Floats{static_cast<float>(a), static_cast<float>(b), static_cast<float>(c),
                    static_cast<float>(d)};
    };
    lanes_.push_back({floats(normal.x(), column.x(), row.x(), 0.0),
                      floats(normal.y(), column.y(), row.y(), 0.0),
                      floats(normal.z(), column.z(), row.z(), 0.0),
                      floats(normal.dot(from_centre_m) + 0.5, column.dot(from_centre_m) + kMiddle,
                             row.dot(from_centre_m) + kMiddle, slack)});
  }
}

// Of a ray that begins outside the box, and of the distance along it, as much more is lost as these
// are longer than the box. Beside a patch the loss of the place, that of the direction, and that of
// the distance along the ray, which is farther by the slope, come together.
PatchLanes::Ray PatchLanes::ray_of(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction,
                                   double length_m) const {
  const double outside_m = (from_m - middle_m_).lpNorm<1>() + length_m;
  const double more = 1.0 + outside_m / edges_m_;
  const Eigen::Vector3f along = direction.cast<float>();
  return {place_of(from_m),
          {along.x(), along.y(), along.z()},
          static_cast<float>((2.0 + 1.0 / kLeastSlope) * more),
          static_cast<float>(slack_m_ * more)};
}

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

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "passes/map/surface/patch_grid.h"

namespace sightline {

struct FollowedRay {
  Eigen::Vector3d from_m, direction;
  double range_m = 0.0;
  PatchLanes::Ray lanes;
};

// A cell in which a ray may cross a patch, and from where to where it lies there, with its slack.
struct RayVisit {
  std::uint32_t cell = 0;  // its number in the grid
  std::uint32_t ray = 0;   // its position among the rays
  float enter_m = 0.0F;
  float leave_m = 0.0F;
};

struct FollowedRays {
  std::vector<FollowedRay> rays;  // with visits
  std::vector<RayVisit> visits;   // in the order of rays
};

// How far a ray of a scan is followed at most, m.
inline constexpr double kLongestPass_m = 60.0;

// Adds the ray of a return, with each cell of the grid in which square_passed() may find anything.
void follow_ray(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m, const PatchGrid& grid,
                FollowedRays& followed);

// The square of the patch through which a ray went and on, if it crosses the patch in this cell,
// which it visits; otherwise -1.
int square_passed(const FollowedRay& ray, std::uint32_t patch, std::uint32_t cell,
                  const PatchGrid& grid);

}  // namespace sightline

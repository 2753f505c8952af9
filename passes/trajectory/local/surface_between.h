#pragma once

#include <Eigen/Core>
#include <span>

namespace sightline {

// Whether a drive passes a place again or is above or below it: storeys look alike, so a match of
// scans does not decide it. Whether points of a map lie on the straight line between two places, in
// its frame: five or more within 0.3 m of it, not counting 0.3 m at each end.
bool is_surface_between(std::span<const Eigen::Vector3d> points_m, const Eigen::Vector3d& a_m,
                        const Eigen::Vector3d& b_m);

}  // namespace sightline

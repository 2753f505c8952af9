#include "passes/emit/unconstrained_sites.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "formats/grid/point_grid.h"

namespace sightline {
namespace {

// Sites are along the way of the poses, or on a route beside it.
constexpr double kNearest_m = 10.0;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

float number_of(const Unconstrained& directions) {
  return (directions.along ? 1.0F : 0.0F) + (directions.across ? 2.0F : 0.0F) +
         (directions.heading ? 4.0F : 0.0F);
}

float sigma_of(const Unconstrained& directions, const std::optional<double>& sigma_m) {
  if (!directions.is_any() || directions.substitute == Substitute::kGivenPoses) return -kInfinity;
  return sigma_m ? static_cast<float>(*sigma_m) : kInfinity;
}

}  // namespace

std::vector<SiteColumn> unconstrained_columns(const Trajectory& trajectory, const Sites& sites) {
  const bool has_any = std::ranges::any_of(
      trajectory.poses, [](const TrajectoryPose& pose) { return pose.unconstrained.is_any(); });
  if (!has_any) return {};
  std::vector<Eigen::Vector3d> places_m;
  for (const TrajectoryPose& pose : trajectory.poses) {
    places_m.emplace_back(rebase(pose.T_map_vehicle, trajectory.frame, sites.frame).translation());
  }
  const PointGrid grid(places_m);
  const std::vector<std::optional<double>> sigmas_m = unconstrained_sigmas_m(trajectory);
  SiteColumn sigma{"pose_sigma_m", "m", {}};
  SiteColumn directions{"unconstrained", "", {}};
  for (const Site& site : sites.sites) {
    const std::optional<NearPoint> nearest =
        grid.nearest(site.T_map_vehicle.translation(), kNearest_m);
    const Unconstrained weak =
        nearest ? trajectory.poses[nearest->index].unconstrained : Unconstrained();
    sigma.values.push_back(sigma_of(weak, nearest ? sigmas_m[nearest->index] : std::nullopt));
    directions.values.push_back(number_of(weak));
  }
  return {sigma, directions};
}

}  // namespace sightline

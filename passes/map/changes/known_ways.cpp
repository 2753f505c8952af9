#include "passes/map/changes/known_ways.h"

#include <cmath>
#include <set>
#include <utility>

namespace sightline {
namespace {

// A drive passed a place where it came this near, in the same direction and at the same height; on
// the same way it came this near from the side, so that there are sites (choose_sites).
constexpr double kPassed_m = 10.0;
constexpr double kSameHeight_m = 3.0;
constexpr double kSameDirection = 0.7071067811865476;  // cosine of 45 degrees
constexpr double kSameWay_m = 2.0;

PointGrid grid_of_scans(const Trajectory& trajectory, const std::vector<std::size_t>& scans) {
  std::vector<Eigen::Vector3d> places_m;
  for (const std::size_t scan : scans) {
    places_m.push_back(trajectory.poses[scan].T_map_vehicle.translation());
  }
  return PointGrid(places_m);
}

}  // namespace

KnownWays::KnownWays(const Drive& drive, const Trajectory& trajectory,
                     std::vector<std::size_t> earlier)
    : drive_(drive),
      trajectory_(trajectory),
      earlier_(std::move(earlier)),
      grid_(grid_of_scans(trajectory, earlier_)) {}

bool KnownWays::know(std::size_t scan, int drives) const {
  const TrajectoryPose& here = trajectory_.poses[scan];
  std::set<std::uint32_t> parts;
  bool comes = false;
  bool goes_on = false;
  const auto meet = [&](const NearPoint& near) {
    const std::size_t earlier = earlier_[near.index];
    const TrajectoryPose& there = trajectory_.poses[earlier];
    const Eigen::Vector3d ahead = there.T_map_vehicle.linear().col(0);
    const Eigen::Vector3d offset_m =
        here.T_map_vehicle.translation() - there.T_map_vehicle.translation();
    const bool passes = there.piece == here.piece && std::abs(offset_m.z()) <= kSameHeight_m &&
                        ahead.dot(here.T_map_vehicle.linear().col(0)) >= kSameDirection;
    if (!passes) return;
    parts.insert(drive_.scans[earlier].part);
    const double along_m = offset_m.dot(ahead);
    if ((offset_m - along_m * ahead).head<2>().norm() > kSameWay_m) return;
    comes = comes || along_m >= 0.0;
    goes_on = goes_on || along_m <= 0.0;
  };
  grid_.visit_within(here.T_map_vehicle.translation(), kPassed_m, meet);
  return comes && goes_on && parts.size() >= static_cast<std::size_t>(drives);
}

}  // namespace sightline

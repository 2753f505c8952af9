#pragma once

#include <optional>
#include <vector>

#include "passes/weakness/site_view.h"

// What an upright board beside the road would add to the match of scans.

namespace sightline {

struct TargetSize {
  double width_m = 1.0;
  double height_m = 2.0;
  double bottom_m = 0.5;  // lower edge above the ground
};

// A flat board on a pole. Both faces are seen.
struct Target {
  Eigen::Vector3d foot_map_m = Eigen::Vector3d::Zero();  // on the ground, below its middle
  Eigen::Vector2d facing = Eigen::Vector2d::UnitX();     // its normal: level, of unit length
  TargetSize size;
};

// The heading of its normal from map +x, in (-180, 180].
double facing_deg(const Target& target);

// Along the ray from p to the board's plane where that is hit within the board.
std::optional<double> distance_to_target_m(const Target& target, const Eigen::Vector3d& p_map_m,
                                           const Eigen::Vector3d& direction);

// A beam that meets the target before anything else.
struct TargetHit {
  std::size_t beam = 0;
  double distance_m = 0.0;
};
std::vector<TargetHit> hits_of(const Target& target, const SiteView& view,
                               const std::vector<Eigen::Vector3d>& directions, double range_m);

// The information of NDs that would be others with the target in the map, by cell: their points and
// those of `hits`, each of which stands for `weight` scans from about there that made the map, 2.8
// cm off on each axis as a map's points are. A cell is in the list where it would have a valid ND.
using ChangedNds = std::map<CellKey, Eigen::Matrix3d>;
struct WeightedHits {
  const SiteView& view;
  const std::vector<TargetHit>& hits;
  double weight = 1.0;
};
ChangedNds nds_with_target(const NearNds& nds, const std::vector<WeightedHits>& hits,
                           const std::vector<Eigen::Vector3d>& directions);

// The information of the view with the target there: its beams end at the target, and samples in
// changed cells are judged by the changed NDs. The same, but for rounding, as casting and adding up
// anew.
struct TargetScene {
  const NearNds& nds;
  const ChangedNds& changed;
  const std::vector<Eigen::Vector3d>& directions;
  double leaf_m = 1.0;
};
Matrix6d information_with_target(const SiteView& view, const std::vector<TargetHit>& hits,
                                 const TargetScene& scene);

}  // namespace sightline

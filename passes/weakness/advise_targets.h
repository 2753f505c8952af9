#pragma once

#include <optional>
#include <vector>

#include "passes/weakness/site_view.h"

// Where a board beside the road would help most.

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

// By cell, the information of valid NDs that change with the target in the map: their points and
// those of `hits`, each of which counts for `weight` scans, 2.8 cm off on each axis.
using ChangedNds = std::map<CellKey, Eigen::Matrix3d>;
struct WeightedHits {
  const SiteView& view;
  const std::vector<TargetHit>& hits;
  double weight = 1.0;
};
ChangedNds nds_with_target(const NearNds& nds, const std::vector<WeightedHits>& hits,
                           const std::vector<Eigen::Vector3d>& directions);

// The information of the view with the target there: its beams end at the target, and samples in
// changed cells use the changed NDs. Equals casting and adding up anew, but for rounding.
struct TargetScene {
  const NearNds& nds;
  const ChangedNds& changed;
  const std::vector<Eigen::Vector3d>& directions;
  double leaf_m = 1.0;
};
Matrix6d information_with_target(const SiteView& view, const std::vector<TargetHit>& hits,
                                 const TargetScene& scene);

struct AdviceOptions {
  TargetSize size;
  double nearest_m = 4.0;  // from the driven line to a place: the map holds no lanes
  double farthest_m = 12.0;
  double along_step_m = 2.0;  // of the grid of places
  double across_step_m = 2.0;
  double beyond_m = 12.0;  // places lie up to so far before and behind the stretch
  double clear_m = 0.7;    // between the board and anything that stands there
  double apart_m = 4.0;    // between two places that are named
  std::size_t most = 3;    // places that are named
};

struct TargetAdvice {
  Target target;
  double beside_m = 0.0;  // from the driven line, left of it positive
  std::size_t nearest_site = 0;
  std::size_t return_count = 0;  // of one scan at the site that sees most of it
  double std_before_m = 0.0;     // along the loose direction, mean over the judged sites
  double std_after_m = 0.0;
  double gain = 0.0;           // 1 - std_after_m / std_before_m
  double gain_at_worst = 0.0;  // the same of the worst site alone
};

// What is known of a stretch.
struct StretchScene {
  const NearNds& nds;
  const Sites& sites;
  const std::vector<SiteView>& views;  // of the judged sites, the worst one first
  // For each view: the standard deviation along the loose direction without a board, m, by the
  // map's own factors where known: views cast on NDs close gaps in walls.
  const std::vector<double>& std_m;
  const std::vector<double>& weights;  // for each view: scans of the map that it stands for
  const std::vector<Eigen::Vector3d>& directions;
  ViewOptions view;
  std::size_t first_site = 0;
  std::size_t last_site = 0;
  double loose_heading_deg = 0.0;  // from map +x
};

// The ground below a place of the map, from the lowest level ND of its column of cells that is
// below the sensor at `p_map_m`; nothing where there is none.
std::optional<double> ground_height_m(const NearNds& nds, const Eigen::Vector2d& place_m,
                                      const Eigen::Vector3d& p_map_m);

// True where something stands less than clear_m from the place, between the ground and the upper
// edge of the board.
bool is_taken(const NearNds& nds, const Target& target, double clear_m);

// `std_m` with the information that `after_m` has more than `before_m`.
double std_with_more_m(double std_m, double before_m, double after_m);

// The best places with any gain, by gain over the judged sites; of equal ones the nearer to the
// stretch's start. Boards face along the loose direction.
std::vector<TargetAdvice> advise_targets(const PassContext& ctx, const AdviceOptions& options,
                                         const StretchScene& scene);

}  // namespace sightline

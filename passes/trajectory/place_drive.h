#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/matching/grid/match_grid.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/followed_scans.h"

// Placing a drive in an earlier map; part of align-drive.

namespace sightline {

// A scan matched with the NDs of a map.
struct MapMatch {
  Pose T_map_lidar = Pose::Identity();
  double likelihood = 0.0;
  double scored_share = 0.0;  // of the points that have an ND near
  bool is_good = false;
};
MapMatch match_to_map(const MatchGrid& grid, const std::vector<Eigen::Vector3d>& points_m,
                      const Pose& T_map_start);

// Near enough for a match to confirm a predicted pose.
bool is_same_place(const Pose& a, const Pose& b);

// Possible poses of a sensor: on the route, looking ahead or back, every step_m of each run.
std::vector<Pose> sensor_places(const Sites& sites, double step_m);

// The pose of a piece of a drive in the map.
struct Placement {
  Pose T_map_own = Pose::Identity();
  std::size_t anchor = 0;  // the scan it was found by
  double support = 0.0;    // likelihoods of the scans that confirm it
  int confirmed = 0;
};

// The placement of a piece that most scans all over it confirm: each is searched for from all
// places, and the drive's own poses are tried as they are. `T_own_lidar`: of all scans of the
// drive. None where no two scans agree. Error: that of reading a scan.
Result<std::optional<Placement>> place_piece(const PassContext& ctx, const MatchGrid& grid,
                                             const Drive& drive, const ScanRange& piece,
                                             const std::vector<Pose>& T_own_lidar,
                                             const std::vector<Pose>& places);

// The ratio of a drive's distances to the map's; 1 where its scans do not differ clearly
// ("Trajectories" in schemas/definitions.md). Eight scans, evenly over the matched ones, are
// matched at several scales (best_scale), from their poses in the map: `T_map_lidar` of all scans.
// Shared by ctx.threads. Error: that of reading a scan.
Result<double> scale_against_map(const PassContext& ctx, const MatchGrid& grid, const Drive& drive,
                                 const std::vector<Pose>& T_map_lidar,
                                 const std::vector<std::uint8_t>& is_matched);

}  // namespace sightline

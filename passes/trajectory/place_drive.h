#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/drive/drive.h"
#include "passes/matching/grid/match_grid.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/pieces/own_pieces.h"

// Where a drive lies in a map that others made; part of align-drive.

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

// Near enough for a match to confirm where its scan was expected.
bool is_same_place(const Pose& a, const Pose& b);

// Where a sensor may have been: on the route, looking ahead or back, every step_m of each run.
std::vector<Pose> sensor_places(const Sites& sites, double step_m);

// How a piece of a drive lies in the map.
struct Placement {
  Pose T_map_own = Pose::Identity();
  std::size_t anchor = 0;  // a scan that it is known from
  double support = 0.0;    // likelihoods of the scans that confirm it
  int confirmed = 0;
};

// The placement of a piece that scans all over it speak for, each looked for from all places; among
// them that the drive's own poses are the map's already. `T_own_lidar`: of all scans of the drive.
// Nothing where no two scans agree. Error: what reading a scan says.
Result<std::optional<Placement>> place_piece(const PassContext& ctx, const MatchGrid& grid,
                                             const Drive& drive, const OwnPiece& piece,
                                             const std::vector<Pose>& T_own_lidar,
                                             const std::vector<Pose>& places);

}  // namespace sightline

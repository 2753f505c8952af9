#pragma once

#include <cstdint>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/matching/match_score.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/graph/pose_graph.h"

namespace sightline {

struct Adjustment {
  std::vector<Pose> T_map_lidar;  // of every scan
  // Of each pose, map axes, order dx dy dz wx wy wz: how far it may be off the first pose, or off
  // the priors where there are any. Planes are taken to err independently of each other.
  std::vector<Matrix6d> covariance;
};

// Moves all poses at once so that what several scans saw as one small plane becomes one: scans of
// `keys` (ascending) are matched to each other through planes, the scans between follow. Edges and
// priors of the graph (between keys) take part as they are. Memory: the points of as many scans as
// see one tile, and the equations. Errors: trajectory-lost (no solution), and what reading says.
Result<Adjustment> adjust_to_planes(PassContext& ctx, const Drive& drive, const PoseGraph& graph,
                                    const std::vector<Pose>& start,
                                    const std::vector<std::uint32_t>& keys);

// The poses as they are, with the covariance that planes lend them there. In a sixth of the time.
Result<Adjustment> weigh_by_planes(PassContext& ctx, const Drive& drive, const PoseGraph& graph,
                                   const std::vector<Pose>& start,
                                   const std::vector<std::uint32_t>& keys);

// The covariance of a point of the vehicle that is `arm_m` from the one it is known of, map axes.
Matrix6d moved_by(const Eigen::Vector3d& arm_m, const Matrix6d& covariance);

}  // namespace sightline

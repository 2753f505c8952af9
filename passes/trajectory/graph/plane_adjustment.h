#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/matching/match_score.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/followed_scans.h"
#include "passes/trajectory/graph/pose_graph.h"

namespace sightline {

struct Adjustment {
  std::vector<Pose> T_map_lidar;  // of every scan
  // Of each pose, map axes, order dx dy dz wx wy wz: relative to the first pose, or to the priors
  // where there are any.
  std::vector<Matrix6d> covariance;
};

// Whether planes move the poses, or only give the covariance of the poses as they are (in a sixth
// of the time).
enum class PlaneUse { kPoses, kCovariance };

// Moves all poses at once so that what several scans measured as one small plane becomes one: the
// scans of `keys` are matched to each other through planes, together with the edges and priors of
// their graph; the scans between them follow. `start`: of every scan. Memory: the points of as many
// scans as one tile is measured by, and the equations. Errors: trajectory-lost (no solution), and
// those of reading a scan.
Result<Adjustment> adjust_to_planes(PassContext& ctx, const Drive& drive, const KeyGraph& keys,
                                    const std::vector<Pose>& start, PlaneUse use);

// The vehicle's poses at the scans from `first` on: adjusted, with their covariance moved from the
// sensor to the vehicle, the scan's `piece`, and its overlap.
std::vector<TrajectoryPose> vehicle_poses(const Drive& drive, const Adjustment& adjusted,
                                          const Odometry& odometry,
                                          const std::vector<std::uint32_t>& piece,
                                          std::size_t first = 0);

}  // namespace sightline

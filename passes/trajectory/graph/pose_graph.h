#pragma once

#include <vector>

#include "formats/base/result.h"
#include "formats/drive/trajectory.h"
#include "formats/geometry.h"
#include "passes/trajectory/local/pose_graph_types.h"

namespace sightline {

struct GraphSolution {
  std::vector<Pose> T_map_pose;
  // Over odometry and loops: root mean square of the norms.
  double rms_translation_m = 0.0;
  double rms_rotation_rad = 0.0;
};

// Least squares over the graph from `start`, by Ceres on one thread: the same bits on every run and
// processor. Error: trajectory-lost where the solver fails.
Result<GraphSolution> solve_pose_graph(const PoseGraph& graph, const std::vector<Pose>& start);

// A trajectory without poses: its frame, and the edges and residuals of its graph.
Trajectory solved_trajectory(const MapFrame& frame, const PoseGraph& graph,
                             const GraphSolution& solution);

}  // namespace sightline

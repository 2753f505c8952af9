#pragma once

#include <cstdint>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/trajectory.h"
#include "formats/geometry.h"
#include "passes/matching/match_score.h"
#include "passes/trajectory/following/followed_scans.h"

namespace sightline {

// A measurement of one pose in the map; sigmas are standard deviations of each axis.
struct GraphPrior {
  std::uint32_t pose = 0;
  Pose T_map_pose = Pose::Identity();
  double sigma_m = 0.1;
  double sigma_rad = 0.01;
};

struct PoseGraph {
  std::vector<GraphEdge> odometry;
  std::vector<GraphEdge> loops;    // and joins between pieces; Huber's loss beyond one sigma
  std::vector<GraphPrior> priors;  // Huber's loss too; without priors the first pose is fixed
  // More poses that are fixed: one of each part that no edge joins to the first.
  std::vector<std::uint32_t> held = {};
};

// A graph of some of a drive's scans.
struct KeyGraph {
  PoseGraph graph;                   // pose i is that of scans[i]
  std::vector<std::uint32_t> scans;  // ascending
};

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

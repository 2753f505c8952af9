#pragma once

#include <cstdint>
#include <vector>

#include "formats/base/result.h"
#include "formats/geometry.h"

namespace sightline {

// What is known of two poses, or of one (a prior), and how well; sigmas are standard deviations of
// each axis.
struct GraphEdge {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  Pose T_from_to = Pose::Identity();
  double sigma_m = 0.1;
  double sigma_rad = 0.01;
};
struct GraphPrior {
  std::uint32_t pose = 0;
  Pose T_map_pose = Pose::Identity();
  double sigma_m = 0.1;
  double sigma_rad = 0.01;
};

struct PoseGraph {
  std::vector<GraphEdge> odometry;
  std::vector<GraphEdge> loops;    // doubted: Huber's loss beyond one sigma
  std::vector<GraphPrior> priors;  // the same; without any the first pose stays where it is
  // More poses that stay where they are: one of each part that nothing joins to the first.
  std::vector<std::uint32_t> held = {};
};

struct GraphSolution {
  std::vector<Pose> T_map_pose;
  // Over odometry and loops: root mean square of the norms.
  double rms_translation_m = 0.0;
  double rms_rotation_rad = 0.0;
};

// Least squares over the graph from `start`, by Ceres on one thread: the same bits on every run.
// Error: trajectory-lost where the solver gives up.
Result<GraphSolution> solve_pose_graph(const PoseGraph& graph, const std::vector<Pose>& start);

}  // namespace sightline

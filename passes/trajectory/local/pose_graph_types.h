#pragma once

#include <cstdint>
#include <vector>

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

}  // namespace sightline

#pragma once

#include <cstdint>
#include <vector>

#include "formats/geometry.h"

namespace sightline {

// A measurement of one pose relative to another; sigmas are standard deviations of each axis.
struct GraphEdge {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  Pose T_from_to = Pose::Identity();
  double sigma_m = 0.1;
  double sigma_rad = 0.01;
};

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

}  // namespace sightline

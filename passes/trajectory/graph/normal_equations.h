#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "passes/matching/match_score.h"
#include "passes/trajectory/graph/pose_graph.h"

// Normal equations over poses, in blocks of 6: small motions of each pose along map axes, order dx
// dy dz wx wy wz (m, rad). pose_graph.cpp explains why they exist beside Ceres.

namespace sightline {

using BlockKey = std::pair<std::uint32_t, std::uint32_t>;  // row >= column

struct Equations {
  std::map<BlockKey, Matrix6d> blocks;
  Eigen::VectorXd gradient;
};

void add_block(std::uint32_t row, std::uint32_t column, const Matrix6d& block, Equations& all);

// Adds edges and priors at these poses, each weighted by its sigmas and by Huber's weight of its
// residual. Without priors the first pose is fixed. Earlier terms stay, except those of poses that
// the graph holds: these are no unknowns.
void add_graph(const PoseGraph& graph, const std::vector<Pose>& poses, Equations& all);

// The blocks that add_graph() changes, as they are before; zero where there is none yet. Put back,
// they save a second set of equations: the earlier one, except for terms that couple held poses.
std::map<BlockKey, Matrix6d> blocks_below_graph(const PoseGraph& graph,
                                                const std::vector<Pose>& poses,
                                                const Equations& all);

}  // namespace sightline

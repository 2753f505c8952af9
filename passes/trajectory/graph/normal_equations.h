#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "passes/matching/match_score.h"
#include "passes/trajectory/graph/pose_graph.h"

// Normal equations over poses, in blocks of 6: steps of each pose along map axes, order dx dy dz wx
// wy wz (m, rad).

namespace sightline {

using BlockKey = std::pair<std::uint32_t, std::uint32_t>;  // row >= column

struct Equations {
  std::map<BlockKey, Matrix6d> blocks;
  Eigen::VectorXd gradient;
};

void add_block(std::uint32_t row, std::uint32_t column, const Matrix6d& block, Equations& all);

// Edges and priors at these poses, each weighted by its sigmas and by Huber's weight of its
// residual. Where there are no priors the first pose is held. What the equations held before takes
// part, but for what it says of poses that the graph holds: these are no unknowns.
void add_graph(const PoseGraph& graph, const std::vector<Pose>& poses, Equations& all);

// The blocks that add_graph() adds to, as they are before; zero where there is none yet. Put back,
// they save a second set of equations: that of before, but for what couples poses that are held.
std::map<BlockKey, Matrix6d> blocks_below_graph(const PoseGraph& graph,
                                                const std::vector<Pose>& poses,
                                                const Equations& all);

}  // namespace sightline

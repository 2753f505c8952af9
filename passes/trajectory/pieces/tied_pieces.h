#pragma once

#include <cstdint>
#include <vector>

#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/local/pose_graph_types.h"

// Part of estimate-trajectory.

namespace sightline {

// So many loops between two pieces hold them.
inline constexpr std::uint32_t kTyingLoops = 5;

// Whether loops hold all that edges join: pieces of odometry with five loops or more between them,
// one every 5 m of way, are tied, and so are those that are tied to one piece. What is joined by an
// edge alone lies as well as a scan was found from afar, and may be askew.
bool are_tied(const Odometry& odometry, const std::vector<GraphEdge>& joins,
              const std::vector<GraphEdge>& loops);

}  // namespace sightline

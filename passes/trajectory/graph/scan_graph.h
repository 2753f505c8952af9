#pragma once

#include <cstdint>
#include <vector>

#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/graph/connect_scans.h"
#include "passes/trajectory/local/estimate_options.h"
#include "passes/trajectory/local/pose_graph_types.h"

namespace sightline {

std::vector<std::uint32_t> all_scans(const Odometry& odometry);

// Scans every 2 m or 0.1 rad, with the first and the last one of each piece: those that planes
// adjust.
std::vector<std::uint32_t> key_scans(const Odometry& odometry);

// Steps of odometry from each of `scans` to the next of its piece.
std::vector<GraphEdge> steps_of(const Odometry& odometry, const std::vector<std::uint32_t>& scans);

// The graph of all scans reduced to `keys`, with priors of these; loops move to the nearest key
// before.
KeyGraph graph_of_keys(const PoseGraph& graph, const Odometry& odometry,
                       std::vector<GraphPrior> priors, const std::vector<std::uint32_t>& keys);

// The graph of all scans: steps, joins and loops, and priors on given poses. Together, the priors
// weigh as much as independent ones every `prior_correlation_m` of way.
PoseGraph graph_of_scans(const EstimateTrajectoryOptions& options, const GivenPoses& given,
                         const Odometry& odometry, const Connections& connections);

// That graph reduced to key scans.
KeyGraph key_graph_of(const EstimateTrajectoryOptions& options, const GivenPoses& given,
                      const Odometry& odometry, const PoseGraph& graph);

}  // namespace sightline

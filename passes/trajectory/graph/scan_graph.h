#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/graph/pose_graph.h"
#include "passes/trajectory/local/estimate_options.h"

// What odometry and given poses say of a drive's scans, as a pose graph; part of
// estimate-trajectory.

namespace sightline {

// Priors on those of `scans` that have a given pose, on a way of so many metres; together they say
// no more than independent ones every `prior_correlation_m` would. Poses are numbered as `scans`.
std::vector<GraphPrior> priors_of(const EstimateTrajectoryOptions& options, double way_m,
                                  const std::vector<std::optional<Pose>>& given,
                                  const std::vector<std::uint32_t>& scans);

std::vector<std::uint32_t> all_scans(const Odometry& odometry);

// Scans far enough from each other to be worth adjusting: with the first and the last one of each
// piece.
std::vector<std::uint32_t> key_scans(const Odometry& odometry);

// Steps of odometry from each of `scans` to the next of its piece.
std::vector<GraphEdge> steps_of(const Odometry& odometry, const std::vector<std::uint32_t>& scans);

// A graph of all scans between keys only, with priors of these; loops move to the nearest key
// before.
PoseGraph graph_of_keys(const PoseGraph& graph, const Odometry& odometry,
                        std::vector<GraphPrior> priors, const std::vector<std::uint32_t>& keys);

}  // namespace sightline

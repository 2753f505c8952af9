#pragma once

#include <cstdint>
#include <vector>

#include "formats/base/result.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/graph/pose_graph.h"
#include "passes/trajectory/local/estimate_options.h"
#include "passes/trajectory/pieces/join_pieces.h"

namespace sightline {

// What connects the scans of an odometry besides its steps.
struct Connections {
  JoinedPieces pieces;
  std::vector<GraphEdge> loops;

  // The joins of pieces, then the loops.
  [[nodiscard]] std::vector<GraphEdge> edges() const;
};

// Joins the pieces of an odometry (join_pieces, which moves its poses) and, if `closes_loops`,
// finds loops (find_loops). With known pieces, only loops between a scan of these and a scan after
// them are searched. A warning for each piece that is not joined. Errors: those of reading a scan.
Result<Connections> connect_scans(const EstimateTask& task, const GivenPoses& given,
                                  Odometry& odometry, const KnownPieces& known = {});

// Least loops between two connected pieces.
inline constexpr std::uint32_t kConnectingLoops = 5;

// Whether loops connect all pieces that edges join: two pieces of odometry with five loops or more
// between them, one every 5 m of way, are connected, directly or by others. A piece that is joined
// by an edge alone is as accurate as a wide search, and may be tilted.
bool are_connected(const Odometry& odometry, const std::vector<GraphEdge>& joins,
                   const std::vector<GraphEdge>& loops);

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
// weigh as much as independent ones every `prior_correlation_m` of way. Where given steps are used,
// steps are as accurate as these (given_drift).
PoseGraph graph_of_scans(const EstimateTask& task, const GivenPoses& given,
                         const Odometry& odometry, const Connections& connections);

// That graph reduced to key scans. Steps that use given motions are those between the poses that
// solve it: planes measure nothing of them.
KeyGraph key_graph_of(const EstimateTask& task, const GivenPoses& given, const Odometry& odometry,
                      const PoseGraph& graph, const std::vector<Pose>& solved);

}  // namespace sightline

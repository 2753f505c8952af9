#pragma once

#include <cstdint>
#include <vector>

#include "formats/base/result.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/local/estimate_options.h"
#include "passes/trajectory/local/pose_graph_types.h"
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

}  // namespace sightline

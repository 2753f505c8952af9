#include "passes/trajectory/graph/connect_scans.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "passes/trajectory/graph/loops.h"
#include "passes/trajectory/pieces/report_pieces.h"

namespace sightline {
namespace {

using PiecePair = std::pair<std::uint32_t, std::uint32_t>;

PiecePair pieces_of(const Odometry& odometry, const GraphEdge& edge) {
  return std::minmax({odometry.piece[edge.from], odometry.piece[edge.to]});
}

}  // namespace

std::vector<GraphEdge> Connections::edges() const {
  std::vector<GraphEdge> all = pieces.edges;
  all.insert(all.end(), loops.begin(), loops.end());
  return all;
}

Result<Connections> connect_scans(const EstimateTask& task, const GivenPoses& given,
                                  Odometry& odometry, const KnownPieces& known) {
  const auto& [ctx, options, drive] = task;
  Connections connections;
  SIGHTLINE_ASSIGN(connections.pieces, join_pieces(ctx, drive, given, odometry, known));
  warn_of_pieces(ctx, drive, odometry, connections.pieces);
  if (!options.closes_loops) return connections;
  LoopSearch search;
  if (known.scans > 0) search = {known.scans, known.scans};
  SIGHTLINE_ASSIGN(connections.loops, find_loops(ctx, drive, odometry, search));
  return connections;
}

bool are_connected(const Odometry& odometry, const std::vector<GraphEdge>& joins,
                   const std::vector<GraphEdge>& loops) {
  std::map<PiecePair, std::uint32_t> loop_count;
  for (const GraphEdge& loop : loops) ++loop_count[pieces_of(odometry, loop)];
  std::vector<std::uint32_t> group(odometry.piece_starts.size() + 1);  // by piece
  std::iota(group.begin(), group.end(), 0U);
  for (const auto& [pair, count] : loop_count) {
    if (count < kConnectingLoops) continue;
    std::ranges::replace(group, std::uint32_t{group[pair.second]},
                         std::uint32_t{group[pair.first]});
  }
  return std::ranges::all_of(joins, [&](const GraphEdge& join) {
    return group[odometry.piece[join.from]] == group[odometry.piece[join.to]];
  });
}

}  // namespace sightline

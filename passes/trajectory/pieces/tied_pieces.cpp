#include "passes/trajectory/pieces/tied_pieces.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace sightline {
namespace {

using PiecePair = std::pair<std::uint32_t, std::uint32_t>;

PiecePair pieces_of(const Odometry& odometry, const GraphEdge& edge) {
  return std::minmax({odometry.piece[edge.from], odometry.piece[edge.to]});
}

}  // namespace

bool are_tied(const Odometry& odometry, const std::vector<GraphEdge>& joins,
              const std::vector<GraphEdge>& loops) {
  std::map<PiecePair, std::uint32_t> loop_count;
  for (const GraphEdge& loop : loops) ++loop_count[pieces_of(odometry, loop)];
  std::vector<std::uint32_t> group(odometry.piece_starts.size() + 1);  // by piece
  std::iota(group.begin(), group.end(), 0U);
  for (const auto& [pair, count] : loop_count) {
    if (count < kTyingLoops) continue;
    std::ranges::replace(group, std::uint32_t{group[pair.second]},
                         std::uint32_t{group[pair.first]});
  }
  return std::ranges::all_of(joins, [&](const GraphEdge& join) {
    return group[odometry.piece[join.from]] == group[odometry.piece[join.to]];
  });
}

}  // namespace sightline

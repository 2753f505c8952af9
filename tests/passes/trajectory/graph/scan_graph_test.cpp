#include "passes/trajectory/graph/scan_graph.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

Odometry pieces(std::uint32_t count) {
  Odometry odometry;
  odometry.piece_starts.resize(count - 1);
  for (std::uint32_t i = 0; i < 4 * count; ++i) odometry.piece.push_back(i / 4);
  return odometry;
}

std::vector<GraphEdge> edges(std::uint32_t from, std::uint32_t to, std::size_t count) {
  GraphEdge edge;
  edge.from = 4 * from;
  edge.to = 4 * to + 1;
  return std::vector<GraphEdge>(count, edge);
}

std::vector<GraphEdge> both(std::vector<GraphEdge> a, const std::vector<GraphEdge>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(ConnectedPieces, AreTiedByFiveLoops) {
  const Odometry two = pieces(2);
  EXPECT_FALSE(are_connected(two, edges(0, 1, 2), edges(0, 1, 4)));
  EXPECT_TRUE(are_connected(two, edges(0, 1, 2), edges(1, 0, 5))) << "whichever is the later";
  EXPECT_FALSE(are_connected(two, edges(0, 1, 2), edges(1, 1, 9))) << "loops within a piece";
  EXPECT_TRUE(are_connected(two, {}, {})) << "nothing was joined";
}

TEST(ConnectedPieces, AreTiedByWayOfAThird) {
  const Odometry three = pieces(3);
  const std::vector<GraphEdge> joins = both(edges(0, 1, 2), edges(0, 2, 2));
  EXPECT_TRUE(are_connected(three, joins, both(edges(2, 1, 5), edges(1, 0, 5))));
  EXPECT_FALSE(are_connected(three, joins, edges(0, 1, 20))) << "the third hangs by its edge";
}

}  // namespace
}  // namespace sightline

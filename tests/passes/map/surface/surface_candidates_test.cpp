#include "passes/map/surface/surface_candidates.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"

namespace sightline {
namespace {

std::uint64_t bit(int column, int row) { return std::uint64_t{1} << (8 * row + column); }

TEST(SolidSquares, StopsWhereAtLeastAsManyRaysEndedAsWentOn) {
  SquareCounts counts;
  counts.returns = {4, 4, 1, 0};
  counts.passes = {2, 3, 0, 1};
  // A ray that was followed stands for two.
  EXPECT_EQ(stopping_squares(counts, 2.0), 0b0101U);
  EXPECT_EQ(open_squares(counts, 2.0), 0b1010U);
}

TEST(SolidSquares, FillsTheHullOfATriangle) {
  const std::uint64_t corners = bit(0, 0) | bit(4, 0) | bit(0, 4);
  std::uint64_t expected = 0;
  for (int column = 0; column <= 4; ++column) {
    for (int row = 0; row + column <= 4; ++row) expected |= bit(column, row);
  }
  EXPECT_EQ(convex_hull(corners), expected);
}

TEST(SolidSquares, KeepsALineALineAndASquareASquare) {
  EXPECT_EQ(convex_hull(0), 0U);
  EXPECT_EQ(convex_hull(bit(5, 2)), bit(5, 2));
  EXPECT_EQ(convex_hull(bit(1, 6) | bit(4, 6)), bit(1, 6) | bit(2, 6) | bit(3, 6) | bit(4, 6));
  EXPECT_EQ(convex_hull(bit(0, 0) | bit(2, 2)), bit(0, 0) | bit(1, 1) | bit(2, 2));
  EXPECT_EQ(convex_hull(bit(3, 0) | bit(3, 2)), bit(3, 0) | bit(3, 1) | bit(3, 2));
}

TEST(SolidSquares, FillsColumnsBetweenTheirEndsAlone) {
  EXPECT_EQ(between_rows(bit(2, 1) | bit(2, 4) | bit(5, 1)),
            bit(2, 1) | bit(2, 2) | bit(2, 3) | bit(2, 4) | bit(5, 1));
  EXPECT_EQ(between_rows(bit(0, 0) | bit(0, 7)), 0x0101010101010101U);
  EXPECT_EQ(between_rows(0), 0U);
}

TEST(SolidSquares, TheHullHoldsItsSquaresAndIsItsOwnHull) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const std::uint64_t squares = random.next() & random.next() & random.next() & random.next();
    const std::uint64_t hull = convex_hull(squares);
    EXPECT_EQ(squares & ~hull, 0U);
    EXPECT_EQ(convex_hull(hull), hull);
  }
}

}  // namespace
}  // namespace sightline

#include "passes/trajectory/graph/contradictions.h"

#include <gtest/gtest.h>

#include "tests/support/box_world.h"

namespace sightline {
namespace {

// Two pieces, the second along the first: scan i of it beside scan i of the other.
constexpr std::uint32_t kCount = 12;

struct TwoPieces {
  Odometry odometry;
  std::vector<Pose> T_map_lidar;
  std::vector<GraphEdge> loops;

  TwoPieces() {
    for (std::uint32_t i = 0; i < 2 * kCount; ++i) {
      odometry.piece.push_back(i / kCount);
      T_map_lidar.push_back(pose_at(5.0 * (i % kCount), i < kCount ? 0.0 : 1.0, 0.0));
    }
    for (std::uint32_t i = 0; i < kCount; ++i) {
      loops.push_back({i, kCount + i, T_map_lidar[i].inverse() * T_map_lidar[kCount + i]});
    }
  }
  void put_off(std::uint32_t loop, double off_m) {
    loops[loop].T_from_to.translation().x() += off_m;
  }
  [[nodiscard]] std::vector<Contradiction> found() const {
    return find_contradictions(odometry, loops, T_map_lidar);
  }
};

TEST(Contradictions, AreNoneWhereLoopsAreMet) {
  TwoPieces pieces;
  for (std::uint32_t i = 0; i < kCount; ++i) pieces.put_off(i, 0.2);
  EXPECT_TRUE(pieces.found().empty());
}

TEST(Contradictions, AreNotMadeByAFalseLoopAmongTrueOnes) {
  TwoPieces pieces;
  pieces.put_off(2, 3.0);
  pieces.put_off(3, 3.0);
  pieces.put_off(9, 3.0);
  EXPECT_TRUE(pieces.found().empty());
}

TEST(Contradictions, AreFoundWhereHalfOfSixLoopsAreOff) {
  TwoPieces pieces;
  pieces.put_off(6, 0.5);
  pieces.put_off(8, -0.75);
  pieces.put_off(10, 0.5);
  const std::vector<Contradiction> found = pieces.found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].first, kCount + 5);
  EXPECT_EQ(found[0].last, kCount + 11);
  EXPECT_EQ(found[0].loop_count, 7U);
  EXPECT_EQ(found[0].off_count, 3U);
  EXPECT_EQ(found[0].earlier, 8U);
  EXPECT_EQ(found[0].later, kCount + 8);
  EXPECT_NEAR(found[0].off_m, 0.75, 1e-12);
}

// Loops come in the order in which chains were followed, and in either direction.
TEST(Contradictions, DoNotDependOnTheOrderOfLoops) {
  TwoPieces pieces;
  for (const std::uint32_t i : {0U, 1U, 2U}) pieces.put_off(i, 1.0);
  const std::vector<Contradiction> expected = pieces.found();
  ASSERT_EQ(expected.size(), 1U);
  for (GraphEdge& loop : pieces.loops) {
    loop = {loop.to, loop.from, loop.T_from_to.inverse(), loop.sigma_m, loop.sigma_rad};
  }
  std::swap(pieces.loops[0], pieces.loops[7]);
  std::swap(pieces.loops[2], pieces.loops[11]);
  const std::vector<Contradiction> found = pieces.found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].first, expected[0].first);
  EXPECT_EQ(found[0].last, expected[0].last);
  EXPECT_EQ(found[0].off_count, 3U);
}

// A third drive that both earlier ones meet: loops to one do not hide contradictions with the
// other.
TEST(Contradictions, OfOnePairAreNotHiddenByLoopsToAnotherPiece) {
  TwoPieces pieces;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    if (i % 3 == 0) pieces.put_off(i, 1.0);
    if (i % 3 != 0) pieces.odometry.piece[i] = 7;
  }
  const std::vector<Contradiction> found = pieces.found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].loop_count, 4U);
  EXPECT_EQ(found[0].off_count, 4U);
}

TEST(Contradictions, NameDrivesAndScans) {
  Drive drive;
  drive.name = "mon";
  drive.later_parts = {"tue"};
  for (std::uint32_t i = 0; i < 2 * kCount; ++i) {
    ScanInfo scan;
    scan.part = i / kCount;
    scan.recording_index = 100 + i;
    drive.scans.push_back(scan);
  }
  TwoPieces pieces;
  for (const std::uint32_t i : {1U, 2U, 3U}) pieces.put_off(i, 0.5);
  pieces.put_off(2, 0.5);
  PassContext ctx;
  std::vector<std::string> warnings;
  ctx.warning_sink = [&](const std::string& text) { warnings.push_back(text); };
  warn_of_contradictions(ctx, drive, pieces.found());
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("drive tue, scans 112 to 118: 3 of 7 loops"), std::string::npos)
      << warnings[0];
  EXPECT_NE(warnings[0].find("scan 114 most (1.00 m, by scan 102 of drive mon)"), std::string::npos)
      << warnings[0];
  warn_of_contradictions(ctx, drive, {});
  EXPECT_EQ(warnings.size(), 1U);
}

}  // namespace
}  // namespace sightline

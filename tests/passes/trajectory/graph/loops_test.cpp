#include "passes/trajectory/graph/loops.h"

#include <gtest/gtest.h>

#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

// Odometry of two pieces, the second of which, from scan `first` on, is off by T_off and counts
// `more_m` more.
Odometry with_later_piece(const TestDrive& test, std::size_t first, const Pose& T_off,
                          double more_m) {
  Odometry odometry;
  for (std::size_t i = 0; i < test.truth.poses.size(); ++i) {
    const Pose T_map_lidar = test.truth.poses[i].T_map_vehicle * test.drive.sensor.T_vehicle_lidar;
    odometry.T_map_lidar.push_back(i >= first ? T_off * T_map_lidar : T_map_lidar);
    odometry.driven_m.push_back(static_cast<double>(i) + (i >= first ? more_m : 0.0));
    odometry.piece.push_back(i >= first ? 1 : 0);
  }
  return odometry;
}

double off_m(const TestDrive& test, const GraphEdge& edge) {
  const Pose& T_vehicle_lidar = test.drive.sensor.T_vehicle_lidar;
  const Pose T_true = (test.truth.poses[edge.from].T_map_vehicle * T_vehicle_lidar).inverse() *
                      test.truth.poses[edge.to].T_map_vehicle * T_vehicle_lidar;
  return (edge.T_from_to.translation() - T_true.translation()).norm();
}

// A drive of two pieces through one street; the second begins where the first ended, and odometry
// has all of it half a metre off.
TEST(Loops, BetweenPiecesAreConfirmedByTheEarlierOneAlone) {
  constexpr std::size_t kCount = 12;
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < kCount; ++i) poses.push_back(pose_at(static_cast<double>(i), 0, 0));
  for (std::size_t i = 0; i < kCount; ++i) {
    poses.push_back(pose_at(static_cast<double>(kCount - i), 0.3, 0));
  }
  const TestDrive test = drive_through(random_street(4), poses, 0.5);
  const Odometry odometry = with_later_piece(test, kCount, pose_at(0.4, 0.3, 0.0), -1.0);
  const std::vector<GraphEdge> loops = value_of(find_loops(TestContext(), test.drive, odometry));
  ASSERT_FALSE(loops.empty());
  for (const GraphEdge& edge : loops) {
    EXPECT_LT(edge.from, kCount);
    EXPECT_GE(edge.to, kCount);
    EXPECT_LT(off_m(test, edge), 0.1) << "scan " << edge.to;
  }
}

// A second drive along a street of 60 m, which odometry has 3 m off and turned a little: a chain of
// loops, each found where the one before it leads.
TEST(Loops, OfAChainAreAllFoundWhereOdometryIsFarOff) {
  constexpr std::size_t kCount = 60;
  std::vector<Pose> poses;
  for (int drive = 0; drive < 2; ++drive) {
    for (std::size_t i = 0; i < kCount; ++i) {
      poses.push_back(pose_at(static_cast<double>(i), 0.3 * drive, 0.0));
    }
  }
  const TestDrive test = drive_through(random_street(4), poses, 0.5);
  const Odometry odometry = with_later_piece(test, kCount, pose_at(2.4, 1.6, 0.01), 1000.0);
  std::vector<GraphEdge> by_one;
  for (const int threads : {1, 3}) {
    const std::vector<GraphEdge> loops =
        value_of(find_loops(TestContext(threads), test.drive, odometry));
    EXPECT_EQ(loops.size(), kCount / 5);
    for (const GraphEdge& edge : loops) EXPECT_LT(off_m(test, edge), 0.05) << "scan " << edge.to;
    if (threads == 1) by_one = loops;
    for (std::size_t i = 0; i < loops.size(); ++i) {
      EXPECT_TRUE(loops[i].T_from_to.isApprox(by_one[i].T_from_to, 0.0));
    }
  }
}

}  // namespace
}  // namespace sightline

#include "passes/trajectory/graph/loops.h"

#include <gtest/gtest.h>
#include <algorithm>

#include "passes/trajectory/graph/scan_graph.h"
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
    odometry.is_matched.push_back(true);
    odometry.is_far.push_back(false);
  }
  return odometry;
}

std::vector<GraphEdge> loops_of(const TestDrive& test, const Odometry& odometry, int threads = 1) {
  const std::vector<GraphEdge> steps = steps_of(odometry, all_scans(odometry));
  return value_of(find_loops(TestContext(threads), test.drive, odometry, steps));
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
  const std::vector<GraphEdge> loops = loops_of(test, odometry);
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
    const std::vector<GraphEdge> loops = loops_of(test, odometry, threads);
    EXPECT_EQ(loops.size(), kCount / 5);
    for (const GraphEdge& edge : loops) EXPECT_LT(off_m(test, edge), 0.05) << "scan " << edge.to;
    if (threads == 1) by_one = loops;
    for (std::size_t i = 0; i < loops.size(); ++i) {
      EXPECT_TRUE(loops[i].T_from_to.isApprox(by_one[i].T_from_to, 0.0));
    }
  }
}

constexpr std::size_t kPassCount = 30;

BoxWorld two_storeys() { return storeys_of({random_street(4), random_street(4)}); }

// Two passes in one direction, on floors of these heights.
TestDrive two_passes(const BoxWorld& world, double first_m, double second_m) {
  std::vector<Pose> poses;
  for (const double z_m : {first_m, second_m}) {
    for (std::size_t i = 0; i < kPassCount; ++i) {
      poses.push_back(Eigen::Translation3d(0.0, 0.0, z_m) *
                      pose_at(static_cast<double>(i), 0.0, 0.0));
    }
  }
  return drive_through(world, poses);
}

// As one piece, after `more_m` of way from pass to pass, which odometry has `off_m` too high.
Odometry one_piece(const TestDrive& test, double more_m, double off_m) {
  const Pose T_off(Eigen::Translation3d(0.0, 0.0, off_m));
  Odometry odometry = with_later_piece(test, kPassCount, T_off, more_m);
  std::ranges::fill(odometry.piece, 0U);
  return odometry;
}

TEST(Loops, BetweenStoreysAreRefusedByTheHeightsOfOdometry) {
  const TestDrive test = two_passes(two_storeys(), 0.0, kTestStorey_m);
  EXPECT_TRUE(loops_of(test, one_piece(test, 100.0, 0.0)).empty());
}

// Of a piece that was joined without its height.
TEST(Loops, BetweenStoreysAreRefusedByTheFloorBetweenThem) {
  for (const bool is_down : {false, true}) {
    const TestDrive test =
        two_passes(two_storeys(), is_down ? kTestStorey_m : 0.0, is_down ? 0.0 : kTestStorey_m);
    const Odometry odometry = with_later_piece(test, kPassCount, Pose::Identity(), 100.0);
    EXPECT_TRUE(loops_of(test, odometry).empty()) << is_down;
  }
}

TEST(Loops, OnOneStoreyAreFoundThoughItsHeightDrifted) {
  const TestDrive test = two_passes(two_storeys(), 0.0, 0.0);
  for (const double off_m : {-0.3, 0.7}) {
    const std::vector<GraphEdge> loops = loops_of(test, one_piece(test, 100.0, off_m));
    EXPECT_GE(loops.size(), 5U) << off_m;
    for (const GraphEdge& edge : loops) {
      EXPECT_LT(sightline::off_m(test, edge), 0.05) << "scan " << edge.to;
    }
  }
}

// Under the open sky, where the steps between may add up to such a height.
TEST(Loops, AfterALongWayAreFoundThoughTheHeightDrifted) {
  const TestDrive test = two_passes(random_street(4), 0.0, 0.0);
  const Odometry odometry = one_piece(test, 1000.0, 1.8);
  std::vector<GraphEdge> steps = steps_of(odometry, all_scans(odometry));
  EXPECT_TRUE(value_of(find_loops(TestContext(), test.drive, odometry, steps)).empty());
  steps[kPassCount - 1].sigma_m = 1.0;  // from the first pass to the second
  const std::vector<GraphEdge> loops =
      value_of(find_loops(TestContext(), test.drive, odometry, steps));
  EXPECT_GE(loops.size(), 5U);
  for (const GraphEdge& edge : loops) EXPECT_LT(off_m(test, edge), 0.15) << "scan " << edge.to;
}

}  // namespace
}  // namespace sightline

#include "passes/trajectory/graph/pose_graph.h"

#include <gtest/gtest.h>
#include <cmath>

#include "formats/base/random.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

Pose along_x(double x_m) {
  Pose pose = Pose::Identity();
  pose.translation().x() = x_m;
  return pose;
}

GraphEdge edge(std::uint32_t from, std::uint32_t to, const Pose& T_from_to, double sigma_m) {
  return {from, to, T_from_to, sigma_m, 0.01};
}

// Two steps of 1 m, and a prior that puts the end at 2.3 m. With equal sigmas the springs share the
// 0.3 m: 0.1 m for each step, 0.1 m for the prior.
TEST(PoseGraph, SharesAContradictionBetweenSpringsOfEqualStrength) {
  PoseGraph graph;
  graph.odometry = {edge(0, 1, along_x(1.0), 0.5), edge(1, 2, along_x(1.0), 0.5)};
  graph.priors = {{0, along_x(0.0), 1e-4, 1e-4}, {2, along_x(2.3), 0.5, 0.01}};
  const GraphSolution solution =
      value_of(solve_pose_graph(graph, {along_x(0.0), along_x(1.0), along_x(2.0)}));
  EXPECT_NEAR(solution.T_map_pose[1].translation().x(), 1.1, 1e-4);
  EXPECT_NEAR(solution.T_map_pose[2].translation().x(), 2.2, 1e-4);
  EXPECT_NEAR(solution.rms_translation_m, 0.1, 1e-4);
}

// Of three steps of 1 m, scans do not constrain the second one ahead: there a prior that puts the
// end at 3.3 m and 0.03 m to the left moves the poses along x, and along y all steps alike.
TEST(PoseGraph, MovesPosesAheadWhereTheirScansDoNotConstrainThem) {
  PoseGraph graph;
  const std::vector<Pose> start = {along_x(0.0), along_x(1.0), along_x(2.0), along_x(3.0)};
  for (std::uint32_t k = 1; k < 4; ++k) {
    graph.odometry.push_back(edge(k - 1, k, along_x(1.0), 0.005));
    graph.odometry.back().sigma_rad = 1e-6;
  }
  graph.odometry[1].more(0, 0) = 0.25;
  Pose end = along_x(3.3);
  end.translation().y() = 0.03;
  graph.priors = {{0, along_x(0.0), 1e-4, 1e-4}, {3, end, 1e-3, 0.1}};
  const std::vector<Pose> found = value_of(solve_pose_graph(graph, start)).T_map_pose;
  EXPECT_NEAR(found[1].translation().x(), 1.0, 0.01);
  EXPECT_NEAR(found[2].translation().x(), 2.3, 0.01);
  EXPECT_NEAR(found[1].translation().y(), 0.01, 0.001);
  EXPECT_NEAR(found[2].translation().y(), 0.02, 0.001);
}

TEST(PoseGraph, KeepsTheFirstPoseWhereNothingElseIsKnown) {
  PoseGraph graph;
  graph.odometry = {edge(0, 1, along_x(1.0), 0.1)};
  const GraphSolution solution = value_of(solve_pose_graph(graph, {along_x(5.0), along_x(7.0)}));
  EXPECT_NEAR(solution.T_map_pose[0].translation().x(), 5.0, 1e-12);
  EXPECT_NEAR(solution.T_map_pose[1].translation().x(), 6.0, 1e-6);
}

TEST(PoseGraph, KeepsOnePoseOfEachPartThatNothingJoinsToTheFirst) {
  PoseGraph graph;
  graph.odometry = {edge(0, 1, along_x(1.0), 0.1), edge(2, 3, along_x(1.0), 0.1)};
  graph.held = {2};
  const GraphSolution solution = value_of(
      solve_pose_graph(graph, {along_x(0.0), along_x(2.0), along_x(300.0), along_x(303.0)}));
  EXPECT_NEAR(solution.T_map_pose[1].translation().x(), 1.0, 1e-6);
  EXPECT_NEAR(solution.T_map_pose[2].translation().x(), 300.0, 1e-12);
  EXPECT_NEAR(solution.T_map_pose[3].translation().x(), 301.0, 1e-6);
}

Pose random_step(Random& random) {
  Pose step = Pose::Identity();
  step.linear() =
      Eigen::AngleAxisd(random.uniform(-0.5, 0.5), Eigen::Vector3d(0.1, 0.2, 1.0).normalized())
          .toRotationMatrix();
  step.translation() = Eigen::Vector3d(random.uniform(0.5, 1.5), random.uniform(-0.2, 0.2), 0.1);
  return step;
}

TEST(PoseGraph, FindsThePosesThatConsistentEdgesCameFrom) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    std::vector<Pose> truth = {Pose::Identity()};
    for (int i = 0; i < 12; ++i) truth.push_back(truth.back() * random_step(random));
    PoseGraph graph;
    std::vector<Pose> start = {truth[0]};
    for (std::uint32_t i = 1; i < truth.size(); ++i) {
      graph.odometry.push_back(edge(i - 1, i, truth[i - 1].inverse() * truth[i], 0.1));
      Pose disturbed = truth[i];
      disturbed.translation() += Eigen::Vector3d(random.normal(), random.normal(), random.normal());
      start.push_back(disturbed);
    }
    graph.loops = {edge(0, 12, truth[0].inverse() * truth[12], 0.1)};
    const GraphSolution solution = value_of(solve_pose_graph(graph, start));
    for (std::size_t i = 0; i < truth.size(); ++i) {
      ASSERT_LT((solution.T_map_pose[i].matrix() - truth[i].matrix()).norm(), 1e-4);
    }
    ASSERT_LT(solution.rms_translation_m, 1e-4);
  }
}

// Drift of 1 % along 100 steps; the last pose is known to be back at the first.
TEST(PoseGraph, TakesDriftOutOfALoop) {
  PoseGraph graph;
  std::vector<Pose> start = {Pose::Identity()};
  for (std::uint32_t i = 1; i <= 100; ++i) {
    const double direction = i <= 50 ? 1.0 : -1.0;
    graph.odometry.push_back(edge(i - 1, i, along_x(direction + 0.01), 0.02));
    start.push_back(start.back() * graph.odometry.back().T_from_to);
  }
  graph.loops = {edge(0, 100, Pose::Identity(), 0.01)};
  ASSERT_NEAR(start.back().translation().x(), 1.0, 1e-9);
  const GraphSolution solution = value_of(solve_pose_graph(graph, start));
  EXPECT_LT(std::abs(solution.T_map_pose[100].translation().x()), 0.1);
  EXPECT_NEAR(solution.T_map_pose[50].translation().x(), 50.0, 0.1);
}

}  // namespace
}  // namespace sightline

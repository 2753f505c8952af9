#include "passes/matching/match_score.h"

#include <gtest/gtest.h>
#include <cmath>

#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

// One round ND of variance 0.25 m^2 at (1, 1, 1) in cell (0, 0, 0) of 2 m.
NdtMap one_ball() {
  NdtMap map;
  Nd nd;
  nd.point_count = 10;
  nd.mean_m = {1.0, 1.0, 1.0};
  nd.covariance_m2 = 0.25 * Eigen::Matrix3d::Identity();
  decompose(nd);
  map.nds = {nd};
  return map;
}

// Points kept only where no motion of a finite difference takes them to another cell: there the
// score has a jump by definition.
std::vector<Eigen::Vector3d> away_from_faces(const std::vector<Eigen::Vector3d>& points_m,
                                             const Pose& pose, double cell_m) {
  std::vector<Eigen::Vector3d> kept_m;
  for (const Eigen::Vector3d& point_m : points_m) {
    const Eigen::Vector3d x = pose * point_m / cell_m;
    const Eigen::Vector3d rest = x - x.array().floor().matrix();
    if (rest.minCoeff() > 0.01 && rest.maxCoeff() < 0.99) kept_m.push_back(point_m);
  }
  return kept_m;
}

TEST(MatchScore, OfOnePointIsTheGaussOfItsDistance) {
  const MatchGrid grid = make_match_grid(one_ball());
  const std::vector<Eigen::Vector3d> points_m = {{1.5, 1.0, 1.0}};
  const MatchScore at = match_score(grid, points_m, Pose::Identity());
  // m^2 = 0.5^2 / 0.25 = 1.
  const double expected = 4.196518186951 * std::exp(-0.5 * 0.248478510124);
  EXPECT_NEAR(at.score, expected, 1e-9);
  EXPECT_NEAR(at.nearest_sum, expected, 1e-9);
  EXPECT_EQ(at.scored_points, 1u);
  // d/dx of exp(-d2/2 (x-1)^2 / 0.25) at x = 1.5 is -d2 * 2 times it.
  EXPECT_NEAR(at.gradient[0], -0.248478510124 * 2.0 * expected, 1e-9);
  EXPECT_NEAR(at.gradient[1], 0.0, 1e-12);
  // Yaw moves the point along y only, where the score is flat.
  EXPECT_NEAR(at.gradient[5], at.gradient[0] * -1.0, 1e-9);
}

TEST(MatchScore, CountsPointsInNeighbouringCellsAndNoFarther) {
  const MatchGrid grid = make_match_grid(one_ball());
  const std::vector<Eigen::Vector3d> points_m = {
      {2.5, 1.0, 1.0}, {2.5, 2.5, 1.0}, {4.5, 1.0, 1.0}, {1e300, 0.0, 0.0}};
  EXPECT_EQ(match_score(grid, points_m, Pose::Identity()).scored_points, 1u);
}

TEST(MatchScore, HasTheGradientAndHessianOfFiniteDifferences) {
  Random random(11);
  for (int trial = 0; trial < 20; ++trial) {
    const double cell_m = trial % 2 == 0 ? 2.0 : 1.0;
    const MatchGrid grid = make_match_grid(simple_map(room_points(5, 4000, 0.03), cell_m));
    const Pose pose = random_pose(random, 0.8, 0.1);
    const std::vector<Eigen::Vector3d> points_m = away_from_faces(
        room_points(100 + static_cast<std::uint64_t>(trial), 200, 0.03), pose, cell_m);
    const MatchScore at = match_score(grid, points_m, pose);
    constexpr double kStep = 1e-5;
    for (int i = 0; i < 6; ++i) {
      const Vector6d motion = kStep * Vector6d::Unit(i);
      const MatchScore more = match_score(grid, points_m, moved(pose, motion));
      const MatchScore less = match_score(grid, points_m, moved(pose, -motion));
      const double slope = (more.score - less.score) / (2.0 * kStep);
      EXPECT_NEAR(at.gradient[i], slope, 1e-5 * (1.0 + at.gradient.cwiseAbs().maxCoeff()));
      const double bend = (more.score - 2.0 * at.score + less.score) / (kStep * kStep);
      EXPECT_NEAR(at.hessian(i, i), bend, 1e-3 * at.hessian.cwiseAbs().maxCoeff());
      for (int j = 0; j < i; ++j) {
        const auto score = [&](double a, double b) {
          const Vector6d both = a * kStep * Vector6d::Unit(i) + b * kStep * Vector6d::Unit(j);
          return match_score(grid, points_m, moved(pose, both)).score;
        };
        const double twist =
            (score(1, 1) - score(1, -1) - score(-1, 1) + score(-1, -1)) / (4.0 * kStep * kStep);
        EXPECT_NEAR(at.hessian(i, j), twist, 1e-3 * at.hessian.cwiseAbs().maxCoeff());
        EXPECT_EQ(at.hessian(i, j), at.hessian(j, i));
      }
    }
  }
}

TEST(MatchScore, MovesByTheRotationVector) {
  Random random(5);
  for (int trial = 0; trial < 100; ++trial) {
    const Pose pose = random_pose(random, 50.0, 3.0);
    Vector6d motion;
    motion << random_vector(random, -1.0, 1.0), random_vector(random, -0.05, 0.05);
    const Pose next = moved(pose, motion);
    const Eigen::Vector3d turn = motion.tail<3>();
    const Eigen::Matrix3d expected =
        Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * pose.linear();
    EXPECT_LT((next.linear() - expected).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_TRUE(next.translation().isApprox(pose.translation() + motion.head<3>(), 1e-15));
    EXPECT_TRUE(is_rigid(next));
  }
}

}  // namespace
}  // namespace sightline

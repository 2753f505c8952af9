#include "passes/matching/matcher.h"

#include <ceres/autodiff_first_order_function.h>
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>
#include <cmath>

#include "passes/matching/scan_preparation.h"
#include "tests/passes/matching/allocation_counter.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

struct Scene {
  MatchGrid grid = make_match_grid(simple_map(room_points(21, 20000, 0.02), 2.0));
  std::vector<Eigen::Vector3d> points_m = voxel_subsample(room_points(22, 8000, 0.02), 1.0);
};

const Scene& scene() {
  static const Scene kScene;
  return kScene;
}

// Minus the score as a function of a motion from `start`, written apart from the matcher and
// derived by Ceres. Which NDs a point scores in is held as it is at `start`, since the score jumps
// where a point changes cells.
struct MinusScore {
  struct Pair {
    Eigen::Vector3d point_m;
    const MatchNd* nd;
  };
  std::vector<Pair> pairs;
  Pose start;

  explicit MinusScore(const Pose& at) : start(at) {
    for (const Eigen::Vector3d& point_m : scene().points_m) {
      const CellKey own = cell_key(start * point_m, 2.0);
      for (const MatchNd& nd : scene().grid.nds) {
        const CellKey key = cell_key(nd.mean_m, 2.0);
        const int steps =
            std::abs(key.x - own.x) + std::abs(key.y - own.y) + std::abs(key.z - own.z);
        if (steps <= 1) pairs.push_back({point_m, &nd});
      }
    }
  }

  template <class T>
  bool operator()(const T* motion, T* cost) const {
    const GaussConstants& gauss = scene().grid.gauss;
    *cost = T(0.0);
    for (const Pair& pair : pairs) {
      const Eigen::Vector3d arm_m = start.linear() * pair.point_m;
      const T arm[3] = {T(arm_m[0]), T(arm_m[1]), T(arm_m[2])};
      T turned[3];
      ceres::AngleAxisRotatePoint(motion + 3, arm, turned);
      T off[3];
      for (int i = 0; i < 3; ++i) {
        off[i] = turned[i] + motion[i] + T(start.translation()[i] - pair.nd->mean_m[i]);
      }
      T maha2(0.0);
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) maha2 += off[i] * T(pair.nd->information_per_m2(i, j)) * off[j];
      }
      *cost += T(gauss.d1) * exp(T(-0.5 * gauss.d2) * maha2);
    }
    return true;
  }
};

TEST(Match, RecoversASmallOffsetOfTheRoom) {
  Random random(1);
  for (int trial = 0; trial < 30; ++trial) {
    const Pose start = random_pose(random, 0.15, 0.02);
    const MatchResult result = match(scene().grid, scene().points_m, start);
    EXPECT_EQ(result.stop, MatchStop::kConverged);
    EXPECT_LT(result.T_map_sensor.translation().norm(), 0.03);
    EXPECT_LT((result.T_map_sensor.linear() - Eigen::Matrix3d::Identity()).norm(), 0.005);
    EXPECT_EQ(result.work, static_cast<std::uint64_t>(result.iterations) * scene().points_m.size());
    EXPECT_LE(result.iterations, 20);
    const std::optional<Matrix6d> covariance = covariance_of(result);
    ASSERT_TRUE(covariance);
    EXPECT_TRUE((*covariance * result.hessian).isApprox(Matrix6d::Identity(), 1e-6));
    EXPECT_GT(result.nearest_voxel_likelihood, 2.0);
    EXPECT_LE(result.nearest_voxel_likelihood, -scene().grid.gauss.d1);
  }
}

TEST(Match, EndsWhereCeresEndsOnTheSameCost) {
  MatchOptions options{.stop_step_m = 1e-8};
  options.stop_step_rad = 1e-9;
  options.kernel = MatchKernel::kExact;
  const Pose start = Pose(Eigen::Translation3d(0.3, -0.2, 0.1));
  const MatchResult result = match(scene().grid, scene().points_m, start, options);
  ASSERT_EQ(result.stop, MatchStop::kConverged);
  Vector6d motion;
  motion << 0.03, -0.02, 0.02, 0.002, -0.002, 0.003;
  ceres::GradientProblem problem(
      new ceres::AutoDiffFirstOrderFunction<MinusScore, 6>(new MinusScore(result.T_map_sensor)));
  ceres::GradientProblemSolver::Options solver;
  solver.max_num_iterations = 100;
  solver.function_tolerance = 0.0;
  solver.gradient_tolerance = 1e-7;
  solver.logging_type = ceres::SILENT;
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(solver, problem, motion.data(), &summary);
  EXPECT_NEAR(result.score, -summary.final_cost, 1e-9 * result.score);
  EXPECT_LT(motion.head<3>().norm(), 1e-6);
  EXPECT_LT(motion.tail<3>().norm(), 1e-7);
}

TEST(Match, NeverStepsFartherThanItsOptionsAllow) {
  Pose far = Pose::Identity();
  far.translation() = Eigen::Vector3d(0.9, 0.4, 0.1);
  Pose before = far;
  for (int limit = 1; limit <= 12; ++limit) {
    const MatchOptions options{.max_iterations = limit};
    const Pose after = match(scene().grid, scene().points_m, far, options).T_map_sensor;
    EXPECT_LE((after.translation() - before.translation()).norm(), 0.2 + 0.005);
    before = after;
  }
}

TEST(Match, WithoutPointsReturnsTheStart) {
  Pose start = Pose::Identity();
  start.translation().x() = 0.3;
  const MatchResult result = match(scene().grid, {}, start);
  EXPECT_EQ(result.stop, MatchStop::kNoPoints);
  EXPECT_TRUE(result.T_map_sensor.isApprox(start, 0.0));
  EXPECT_EQ(result.iterations, 0);
}

TEST(Match, OfPointsInOnePlaneMovesOnlyWhereThePlaneConstrains) {
  std::vector<Eigen::Vector3d> floor_m;
  for (int x = -9; x <= 9; ++x) {
    for (int y = -5; y <= 5; ++y) floor_m.push_back({1.0 * x, 1.0 * y, -2.0 + 0.02 * x});
  }
  Pose start = Pose::Identity();
  start.translation().z() = 0.15;
  const MatchResult result = match(scene().grid, floor_m, start);
  EXPECT_TRUE(is_finite(result));
  EXPECT_LE(result.iterations, 35);
  EXPECT_NEAR(result.T_map_sensor.translation().z(), 0.0, 0.02);
}

TEST(Match, OfASinglePointEndsWithFiniteNumbers) {
  const std::vector<Eigen::Vector3d> point_m = {{3.3, 2.2, -1.5}};
  EXPECT_TRUE(is_finite(match(scene().grid, point_m, Pose::Identity())));
}

TEST(Match, AllocatesNothingWhileItIterates) {
  const Pose start = Pose(Eigen::Translation3d(0.5, -0.4, 0.0));
  scene();  // made at its first use, which is not to be counted
  const auto allocations_of = [&](int iterations) {
    MatchOptions options{.max_iterations = iterations};
    options.stop_step_m = 0.0;
    const std::size_t before = allocation_count();
    EXPECT_EQ(match(scene().grid, scene().points_m, start, options).iterations, iterations);
    return allocation_count() - before;
  };
  EXPECT_EQ(allocations_of(1), allocations_of(30));
}

TEST(Match, GivesTheSameResultWhereverTheMapLies) {
  // A shift by whole cells must not change more than rounding.
  const Eigen::Vector3d shift_m(2000.0, -4000.0, 20.0);
  const NdtMap near = simple_map(room_points(21, 20000, 0.02), 2.0);
  std::vector<Eigen::Vector3d> moved_points_m = room_points(21, 20000, 0.02);
  for (Eigen::Vector3d& point_m : moved_points_m) point_m += shift_m;
  const MatchGrid far_grid = make_match_grid(simple_map(moved_points_m, 2.0));
  const Pose start = Pose(Eigen::Translation3d(0.2, 0.1, 0.05));
  Pose far_start = start;
  far_start.translation() += shift_m;
  const MatchResult a = match(make_match_grid(near), scene().points_m, start);
  const MatchResult b = match(far_grid, scene().points_m, far_start);
  EXPECT_LT((b.T_map_sensor.translation() - shift_m - a.T_map_sensor.translation()).norm(), 1e-6);
}

}  // namespace
}  // namespace sightline

#include "passes/trajectory/graph/normal_equations.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <numeric>
#include <vector>

#include "formats/base/random.h"

namespace sightline {
namespace {

// Every pose, its neighbour, and some pairs far apart; positive definite.
Equations random_equations(std::uint32_t poses) {
  Random random(poses);
  Equations all;
  all.gradient = Eigen::VectorXd::Zero(6 * static_cast<Eigen::Index>(poses));
  for (std::uint32_t row = 0; row < poses; ++row) {
    for (std::uint32_t column = 0; column <= row; ++column) {
      if (row > column + 1 && random.uniform(0.0, 1.0) > 0.1) continue;
      Matrix6d block;
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) block(i, j) = random.normal();
      if (row == column) {
        block = (block + block.transpose()).eval();
        block.diagonal().array() += 30.0 * poses;
      }
      add_block(row, column, block, all);
    }
  }
  for (Eigen::Index i = 0; i < all.gradient.size(); ++i) all.gradient[i] = random.normal();
  return all;
}

Eigen::MatrixXd dense(const Equations& all) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(all.gradient.size(), all.gradient.size());
  for (const auto& [key, block] : all.blocks) {
    const Eigen::Index row = 6 * static_cast<Eigen::Index>(key.first);
    const Eigen::Index column = 6 * static_cast<Eigen::Index>(key.second);
    matrix.block<6, 6>(row, column) = block;
    matrix.block<6, 6>(column, row) = block.transpose();
  }
  return matrix;
}

TEST(NormalSolver, SolvesAsTheDenseMatrixDoes) {
  for (const std::uint32_t poses : {1U, 2U, 30U}) {
    const Equations all = random_equations(poses);
    const Eigen::MatrixXd matrix = dense(all);
    NormalSolver solver;
    ASSERT_TRUE(solver.factor(all));
    const Eigen::VectorXd expected = matrix.ldlt().solve(all.gradient);
    EXPECT_LT((solver.solve(all.gradient) - expected).norm(), 1e-10 * expected.norm());
    const Eigen::MatrixXd inverse = matrix.inverse();
    const std::vector<Matrix6d> blocks = solver.inverse_blocks();
    ASSERT_EQ(blocks.size(), poses);
    for (std::uint32_t pose = 0; pose < poses; ++pose) {
      const Eigen::Index at = 6 * static_cast<Eigen::Index>(pose);
      const Matrix6d own = inverse.block<6, 6>(at, at);
      EXPECT_LT((blocks[pose] - own).norm(), 1e-10 * own.norm());
      EXPECT_EQ(blocks[pose], blocks[pose].transpose());
    }
  }
}

TEST(NormalSolver, RefusesWhatIsNotPositiveDefinite) {
  Equations all = random_equations(5);
  all.blocks.at({3, 3})(2, 2) = -1.0;
  EXPECT_FALSE(NormalSolver().factor(all));
}

TEST(NormalSolver, MatrixHoldsEachBlockOnceAboveTheDiagonal) {
  const Equations all = random_equations(30);
  const std::vector<std::uint32_t> place_of = elimination_places(all);
  std::vector<std::uint32_t> sorted = place_of;
  std::ranges::sort(sorted);
  std::vector<std::uint32_t> every(30);
  std::iota(every.begin(), every.end(), 0U);
  ASSERT_EQ(sorted, every);
  const Eigen::SparseMatrix<double> matrix = upper_matrix(all, place_of);
  ASSERT_TRUE(matrix.isCompressed());
  ASSERT_EQ(static_cast<std::size_t>(matrix.nonZeros()), 36 * all.blocks.size());
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(matrix.rows(), matrix.cols());
  const Eigen::MatrixXd symmetric = dense(all);
  for (std::uint32_t a = 0; a < 30; ++a) {
    for (std::uint32_t b = 0; b < 30; ++b) {
      if (place_of[a] > place_of[b]) continue;
      expected.block<6, 6>(6 * place_of[a], 6 * place_of[b]) = symmetric.block<6, 6>(6 * a, 6 * b);
    }
  }
  EXPECT_EQ(Eigen::MatrixXd(matrix), expected);
  for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
    EXPECT_TRUE(std::is_sorted(matrix.innerIndexPtr() + matrix.outerIndexPtr()[column],
                               matrix.innerIndexPtr() + matrix.outerIndexPtr()[column + 1]));
  }
}

// A street that is a chain, closed by one loop: elimination from one end would fill a column for
// the loop, but no more than that many.
TEST(NormalSolver, OrderFillsInLittle) {
  constexpr std::uint32_t kPoses = 400;
  Equations all;
  all.gradient = Eigen::VectorXd::Zero(6 * kPoses);
  const auto couple = [&](std::uint32_t a, std::uint32_t b) {
    add_block(std::max(a, b), std::min(a, b),
              a == b ? Matrix6d(Matrix6d::Identity() * 10.0) : Matrix6d(Matrix6d::Identity()), all);
  };
  Random random(1);
  std::vector<std::uint32_t> name(kPoses);  // poses in any order
  std::iota(name.begin(), name.end(), 0U);
  for (std::uint32_t i = kPoses - 1; i > 0; --i) {
    std::swap(name[i], name[static_cast<std::size_t>(random.uniform(0.0, 1.0) * i)]);
  }
  for (std::uint32_t i = 0; i < kPoses; ++i) couple(name[i], name[i]);
  for (std::uint32_t i = 1; i < kPoses; ++i) couple(name[i], name[i - 1]);
  couple(name[0], name[kPoses - 1]);
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Upper, Eigen::NaturalOrdering<int>> llt(
      upper_matrix(all, elimination_places(all)));
  const Eigen::SparseMatrix<double> factor = llt.matrixL();
  EXPECT_LT(factor.nonZeros(), 36 * 4 * kPoses);
}

TEST(AddGraph, HoldsPosesAsIfTheyWereNoUnknowns) {
  constexpr std::uint32_t kPoses = 9;
  const std::vector<Pose> poses(kPoses, Pose::Identity());
  PoseGraph graph;
  Pose off = Pose::Identity();
  off.translation().x() = 0.05;
  graph.odometry = {{0, 1, off, 0.1, 0.1}, {4, 3, off, 0.1, 0.1}, {7, 8, off, 0.1, 0.1}};
  graph.priors = {{2, off, 0.1, 0.1}, {4, off, 0.1, 0.1}};
  Equations free = random_equations(kPoses);
  Equations held = free;
  add_graph(graph, poses, free);
  graph.held = {4, 7, 1};
  add_graph(graph, poses, held);
  const std::vector<std::uint32_t> left = {0, 2, 3, 5, 6, 8};
  const auto rows = static_cast<Eigen::Index>(6 * left.size());
  Eigen::MatrixXd matrix(rows, rows);
  Eigen::VectorXd gradient(rows);
  const Eigen::MatrixXd whole = dense(free);
  for (std::size_t i = 0; i < left.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(6 * i);
    gradient.segment<6>(row) = free.gradient.segment<6>(6 * left[i]);
    for (std::size_t j = 0; j < left.size(); ++j) {
      matrix.block<6, 6>(row, static_cast<Eigen::Index>(6 * j)) =
          whole.block<6, 6>(6 * left[i], 6 * left[j]);
    }
  }
  const Eigen::VectorXd expected = matrix.ldlt().solve(gradient);
  NormalSolver solver;
  ASSERT_TRUE(solver.factor(held));
  const Eigen::VectorXd found = solver.solve(held.gradient);
  for (std::size_t i = 0; i < left.size(); ++i) {
    const Vector6d of_one = expected.segment<6>(static_cast<Eigen::Index>(6 * i));
    EXPECT_LT((found.segment<6>(6 * left[i]) - of_one).norm(), 1e-9 * of_one.norm());
  }
  for (const std::uint32_t pose : graph.held) {
    EXPECT_EQ(found.segment<6>(6 * pose).norm(), 0.0);
    EXPECT_LT(solver.inverse_blocks()[pose].norm(), 1e-7);
  }
}

TEST(BlocksBelowGraph, AreWhatTheGraphAddsTo) {
  const std::vector<Pose> poses(4, Pose::Identity());
  PoseGraph graph;
  graph.odometry = {{0, 1, Pose::Identity(), 0.1, 0.1}, {2, 3, Pose::Identity(), 0.1, 0.1}};
  Equations all;
  all.gradient = Eigen::VectorXd::Zero(24);
  add_block(1, 0, Matrix6d::Constant(3.0), all);
  add_block(3, 0, Matrix6d::Constant(4.0), all);
  const Equations before = all;
  const std::map<BlockKey, Matrix6d> below = blocks_below_graph(graph, poses, all);
  add_graph(graph, poses, all);
  ASSERT_NE(all.blocks.at({1, 0}), before.blocks.at({1, 0}));
  for (const auto& [key, block] : below) all.blocks[key] = block;
  for (const auto& [key, block] : all.blocks) {
    const auto found = before.blocks.find(key);
    EXPECT_EQ(block, found == before.blocks.end() ? Matrix6d(Matrix6d::Zero()) : found->second);
  }
}

}  // namespace
}  // namespace sightline

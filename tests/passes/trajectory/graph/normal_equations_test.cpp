#include "passes/trajectory/graph/normal_equations.h"

#include <gtest/gtest.h>

#include <vector>

#include "formats/base/random.h"

namespace sightline {
namespace {

// Every pose, and some pairs far apart.
Equations random_equations(std::uint32_t poses) {
  Random random(poses);
  Equations all;
  all.gradient = Eigen::VectorXd::Zero(6 * static_cast<Eigen::Index>(poses));
  for (std::uint32_t row = 0; row < poses; ++row) {
    for (std::uint32_t column = 0; column <= row; ++column) {
      if (row != column && random.uniform(0.0, 1.0) > 0.2) continue;
      Matrix6d block;
      for (int i = 0; i < 6; ++i) {
        for (int j = 0; j < 6; ++j) block(i, j) = random.normal();
      }
      add_block(row, column, block, all);
    }
  }
  return all;
}

TEST(NormalEquations, MatrixHoldsEachBlockWhereTripletsPutIt) {
  for (const std::uint32_t poses : {1U, 2U, 30U}) {
    const Equations all = random_equations(poses);
    std::vector<Eigen::Triplet<double>> triplets;
    for (const auto& [key, block] : all.blocks) {
      for (int i = 0; i < 6; ++i) {
        for (int j = 0; j < 6; ++j) {
          triplets.emplace_back(static_cast<int>(6 * key.first) + i,
                                static_cast<int>(6 * key.second) + j, block(i, j));
        }
      }
    }
    Eigen::SparseMatrix<double> expected(all.gradient.size(), all.gradient.size());
    expected.setFromTriplets(triplets.begin(), triplets.end());
    const Eigen::SparseMatrix<double> matrix = matrix_of(all);
    ASSERT_TRUE(matrix.isCompressed());
    ASSERT_EQ(matrix.nonZeros(), expected.nonZeros());
    for (Eigen::Index column = 0; column <= matrix.cols(); ++column) {
      EXPECT_EQ(matrix.outerIndexPtr()[column], expected.outerIndexPtr()[column]);
    }
    for (Eigen::Index i = 0; i < matrix.nonZeros(); ++i) {
      ASSERT_EQ(matrix.innerIndexPtr()[i], expected.innerIndexPtr()[i]);
      ASSERT_EQ(matrix.valuePtr()[i], expected.valuePtr()[i]);
    }
  }
}

}  // namespace
}  // namespace sightline

#include "formats/symmetric_eigen.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"

namespace sightline {
namespace {

// Whatever the method: values ascend, vectors are orthonormal, and together they make the matrix.
template <int N>
void expect_decomposes(Random& random) {
  using Matrix = Eigen::Matrix<double, N, N>;
  Matrix matrix;
  for (int row = 0; row < N; ++row) {
    for (int column = 0; column < N; ++column) matrix(row, column) = random.uniform(-3.0, 3.0);
  }
  const Matrix lower = matrix.template triangularView<Eigen::Lower>();
  const Matrix symmetric = lower.template selfadjointView<Eigen::Lower>();
  const SymmetricEigen<N> eigen = symmetric_eigen<N>(matrix);
  for (int i = 0; i + 1 < N; ++i) EXPECT_LE(eigen.values[i], eigen.values[i + 1]);
  const Matrix squares = eigen.vectors.transpose() * eigen.vectors;
  EXPECT_TRUE(squares.isIdentity(1e-12));
  const Matrix again = eigen.vectors * eigen.values.asDiagonal() * eigen.vectors.transpose();
  EXPECT_TRUE(again.isApprox(symmetric, 1e-12)) << matrix;
}

TEST(SymmetricEigen, DecomposesTheLowerTriangle) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    expect_decomposes<2>(random);
    expect_decomposes<3>(random);
    expect_decomposes<6>(random);
  }
}

}  // namespace
}  // namespace sightline

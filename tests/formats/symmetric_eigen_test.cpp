#include "formats/symmetric_eigen.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "formats/base/random.h"

namespace sightline {
namespace {

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

std::vector<Eigen::Matrix3d> covariances() {
  Random random(2);
  std::vector<Eigen::Matrix3d> all;
  for (int i = 0; i < 300; ++i) {
    Eigen::Matrix3d points;
    for (double& value : points.reshaped()) value = random.normal();
    points.row(2) *= i % 3 == 0 ? 1e-4 : 1.0;
    if (i % 5 == 0) points.row(1).setZero();
    if (i % 7 == 0) points.row(0) = points.row(1);
    all.emplace_back(std::ldexp(1.0, 10 * (i % 41) - 200) * points * points.transpose());
  }
  all.emplace_back(Eigen::Matrix3d::Zero());
  all.emplace_back(Eigen::Matrix3d::Identity());
  all.emplace_back(Eigen::Matrix3d::Ones());
  all.emplace_back(Eigen::Matrix3d::Constant(1e300));
  all.emplace_back(Eigen::Matrix3d::Constant(4e-320));
  all.emplace_back(Eigen::Vector3d(3.0, -1.0, 3.0).asDiagonal());
  return all;
}

TEST(SymmetricEigen, OfThreeRowsFindsWhatEigenFinds) {
  for (const Eigen::Matrix3d& matrix : covariances()) {
    const double scale = matrix.cwiseAbs().maxCoeff();
    const SymmetricEigen<3> found = symmetric_eigen<3>(matrix);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> oracle(matrix);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(found.values[i], oracle.eigenvalues()[i], 1e-13 * scale) << matrix;
    }
    EXPECT_TRUE((found.vectors.transpose() * found.vectors).isIdentity(4e-15)) << matrix;
    const Eigen::Matrix3d again = found.vectors *
                                  (found.values / std::max(scale, 1e-300)).asDiagonal() *
                                  found.vectors.transpose();
    EXPECT_TRUE((again - matrix / std::max(scale, 1e-300)).cwiseAbs().maxCoeff() < 1e-13) << matrix;
  }
}

TEST(SymmetricEigen, OfThreeRowsTakesWhatIsLeftOfRoundingForNothing) {
  Eigen::Matrix3d round = Eigen::Matrix3d::Identity();
  round(1, 0) = 3e-14;
  EXPECT_EQ(symmetric_eigen<3>(round).vectors.cwiseAbs(), Eigen::Matrix3d::Identity());
  round(1, 0) = 3e-13;
  EXPECT_FALSE(symmetric_eigen<3>(round).vectors.cwiseAbs().isIdentity(0.5));
}

TEST(SymmetricEigen, OfManyMatricesIsThatOfEachToTheBit) {
  std::vector<Eigen::Matrix3d> matrices = covariances();
  const double no_number = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 40; i < 80; i += 9) matrices[i](1, 0) = no_number;
  matrices[90](2, 2) = std::numeric_limits<double>::infinity();
  for (const std::size_t count :
       {std::size_t{0}, std::size_t{1}, std::size_t{5}, matrices.size()}) {
    const std::span<const Eigen::Matrix3d> some = std::span(matrices).last(count);
    std::vector<SymmetricEigen<3>> found(count);
    symmetric_eigen(some, found);
    for (std::size_t i = 0; i < count; ++i) {
      if (!some[i].allFinite()) continue;
      const SymmetricEigen<3> alone = symmetric_eigen<3>(some[i]);
      EXPECT_EQ(found[i].values, alone.values) << some[i];
      EXPECT_EQ(found[i].vectors, alone.vectors) << some[i];
    }
  }
}

}  // namespace
}  // namespace sightline

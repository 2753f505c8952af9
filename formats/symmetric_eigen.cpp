#include "formats/symmetric_eigen.h"

#include <Eigen/Eigenvalues>

#include <type_traits>

namespace sightline {
namespace {

// One solver for 2 and 6 rows: to compile, each of its own size takes as long, and gives the same
// bits. For 3 rows Eigen has a way of its own.
template <int N>
using Solved = std::conditional_t<N == 3, Eigen::Matrix3d,
                                  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>>;

}  // namespace

template <int N>
SymmetricEigen<N> symmetric_eigen(const Eigen::Matrix<double, N, N>& matrix) {
  const Eigen::SelfAdjointEigenSolver<Solved<N>> solver{Solved<N>(matrix)};
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template SymmetricEigen<2> symmetric_eigen<2>(const Eigen::Matrix<double, 2, 2>& matrix);
template SymmetricEigen<3> symmetric_eigen<3>(const Eigen::Matrix<double, 3, 3>& matrix);
template SymmetricEigen<6> symmetric_eigen<6>(const Eigen::Matrix<double, 6, 6>& matrix);

}  // namespace sightline

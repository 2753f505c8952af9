#include "formats/symmetric_eigen.h"

#include <Eigen/Eigenvalues>

namespace sightline {

template <int N>
SymmetricEigen<N> symmetric_eigen(const Eigen::Matrix<double, N, N>& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, N, N>> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template SymmetricEigen<2> symmetric_eigen<2>(const Eigen::Matrix<double, 2, 2>& matrix);
template SymmetricEigen<3> symmetric_eigen<3>(const Eigen::Matrix<double, 3, 3>& matrix);
template SymmetricEigen<6> symmetric_eigen<6>(const Eigen::Matrix<double, 6, 6>& matrix);

}  // namespace sightline

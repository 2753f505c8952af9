#include "passes/matching/horizontal_curvature.h"

#include <Eigen/Cholesky>

#include "formats/symmetric_eigen.h"

namespace sightline {

HorizontalCurvature horizontal_curvature(const Matrix6d& hessian) {
  const Eigen::Matrix<double, 2, 4> mixed = hessian.topRightCorner<2, 4>();
  Eigen::Matrix4d others = hessian.bottomRightCorner<4, 4>();
  others.diagonal().array() += 1e-6 * others.diagonal().cwiseAbs().maxCoeff();
  const Eigen::Matrix<double, 4, 2> followed = others.ldlt().solve(mixed.transpose());
  const Eigen::Matrix2d schur = hessian.topLeftCorner<2, 2>() - mixed * followed;
  const SymmetricEigen<2> eigen = symmetric_eigen<2>(0.5 * (schur + schur.transpose()));
  return {eigen.values[0], eigen.values[1], eigen.vectors.col(0)};
}

}  // namespace sightline

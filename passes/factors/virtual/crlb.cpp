#include "passes/factors/virtual/crlb.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "formats/base/portable_math.h"
#include "formats/symmetric_eigen.h"

namespace sightline {
namespace {

constexpr double kPriorPosition_m = 10.0;
constexpr double kPriorAngle_rad = 10.0 * std::numbers::pi / 180.0;

Matrix6d with_prior(const Matrix6d& information) {
  Matrix6d sum = information;
  for (int i = 0; i < 3; ++i) {
    sum(i, i) += 1.0 / (kPriorPosition_m * kPriorPosition_m);
    sum(i + 3, i + 3) += 1.0 / (kPriorAngle_rad * kPriorAngle_rad);
  }
  return sum;
}

// Information on x and y alone: z, roll, pitch and yaw eliminated.
Eigen::Matrix2d horizontal_part(const Matrix6d& information) {
  const Eigen::Matrix<double, 4, 4> others = information.bottomRightCorner<4, 4>();
  const Eigen::Matrix<double, 4, 2> coupling = information.bottomLeftCorner<4, 2>();
  const Eigen::Matrix<double, 4, 2> solved = others.ldlt().solve(coupling);
  const Eigen::Matrix2d part = information.topLeftCorner<2, 2>() - coupling.transpose() * solved;
  return 0.5 * (part + part.transpose());
}

// Information on yaw, the last of the six, alone.
double yaw_part(const Matrix6d& information) {
  const Eigen::Matrix<double, 5, 5> others = information.topLeftCorner<5, 5>();
  const Eigen::Matrix<double, 5, 1> coupling = information.topRightCorner<5, 1>();
  const Eigen::Matrix<double, 5, 1> solved = others.ldlt().solve(coupling);
  return information(5, 5) - coupling.dot(solved);
}

double heading_deg(const Eigen::Vector2d& direction) {
  const double degrees = portable_atan2(direction.y(), direction.x()) * 180.0 / std::numbers::pi;
  const double positive = degrees < 0.0 ? degrees + 180.0 : degrees;
  return positive >= 180.0 ? positive - 180.0 : positive;
}

}  // namespace

Crlb crlb(const Matrix6d& information) {
  const Matrix6d posterior = with_prior(information);
  const SymmetricEigen<2> eigen = symmetric_eigen<2>(horizontal_part(posterior));
  Crlb bound;
  bound.max_m = 1.0 / std::sqrt(eigen.values[0]);
  bound.min_m = 1.0 / std::sqrt(eigen.values[1]);
  bound.heading_deg = heading_deg(eigen.vectors.col(0));
  bound.yaw_rad = 1.0 / std::sqrt(yaw_part(posterior));
  return bound;
}

double std_along_m(const Crlb& bound, double heading_deg) {
  const double turned_rad = (heading_deg - bound.heading_deg) * std::numbers::pi / 180.0;
  const SinCos turned = portable_sin_cos(turned_rad);
  return portable_hypot(bound.max_m * turned.cos, bound.min_m * turned.sin);
}

}  // namespace sightline

#include "passes/matching/covariance/match_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace sightline {
namespace {

constexpr double kWeak_m = 0.25;
constexpr double kWeak_rad = 0.02;
constexpr double kUnknown_m = 100.0;
constexpr double kUnknown_rad = 1.0;
constexpr double kWander_m = 0.6;
constexpr double kWander_rad = 0.01;

Matrix6d diagonal(double m2, double rad2) {
  Vector6d variances;
  variances << m2, m2, m2, rad2, rad2, rad2;
  return variances.asDiagonal();
}

}  // namespace

InformationScale default_information_scale() { return {0.5, 0.008, 0.0003, 1.0}; }

bool is_covariance(const Matrix6d& matrix) {
  const double size = matrix.cwiseAbs().maxCoeff();
  return matrix.allFinite() && matrix.diagonal().minCoeff() >= 0.0 &&
         (matrix - matrix.transpose()).cwiseAbs().maxCoeff() <= 1e-6 * size;
}

// With S the structure's information, (a S^-1 + B)^-1 = (a + S B)^-1 S = I, and
// (I^-1 + d d^T)^-1 = I - I d d^T I / (1 + d^T I d) (Sherman and Morrison 1950). The step d is
// shortened where S is weak: it is no longer than a match may wander.
Matrix6d match_information(const StructureEvidence& structure, const InformationScale& scale) {
  Matrix6d sum =
      structure.information * diagonal(scale.map_m * scale.map_m, scale.map_rad * scale.map_rad);
  sum.diagonal().array() += scale.variance_factor;
  const Eigen::PartialPivLU<Matrix6d> factors(sum);
  Matrix6d result;
  for (int i = 0; i < 6; ++i) result.col(i) = factors.solve(structure.information.col(i));
  result = (0.5 * (result + result.transpose())).eval();
  const Matrix6d held = structure.information +
                        diagonal(1.0 / (kWander_m * kWander_m), 1.0 / (kWander_rad * kWander_rad));
  const Vector6d step = held.llt().solve(structure.descent);
  const Vector6d pull = result * step;
  const double more = 1.0 + step.dot(pull);
  return (result - pull * pull.transpose() / more) / scale.covariance_factor;
}

// (I + P^-1)^-1 = (1 + P I)^-1 P.
Matrix6d covariance_of_unknown_start(const Matrix6d& information) {
  const Matrix6d start = diagonal(kUnknown_m * kUnknown_m, kUnknown_rad * kUnknown_rad);
  Matrix6d sum = start * information;
  sum.diagonal().array() += 1.0;
  const Eigen::PartialPivLU<Matrix6d> factors(sum);
  Matrix6d result;
  for (int i = 0; i < 6; ++i) result.col(i) = factors.solve(start.col(i));
  return 0.5 * (result + result.transpose());
}

std::uint32_t weak_axes(const Matrix6d& covariance, const Pose& T_map_vehicle) {
  std::uint32_t bits = 0;
  for (int i = 0; i < 6; ++i) {
    const int first = i < 3 ? 0 : 3;
    const Eigen::Vector3d axis = T_map_vehicle.linear().col(i - first);
    const double variance = axis.dot(covariance.block<3, 3>(first, first) * axis);
    const double most = i < 3 ? kWeak_m : kWeak_rad;
    if (!(variance <= most * most)) bits |= 1U << static_cast<unsigned>(i);
  }
  return bits;
}

}  // namespace sightline

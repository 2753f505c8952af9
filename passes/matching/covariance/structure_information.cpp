#include "passes/matching/covariance/structure_information.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "formats/base/portable_math.h"
#include "formats/symmetric_eigen.h"

namespace sightline {
namespace {

PlanarMotion planar(const StructureObservation& one) {
  return {one.by_motion[0], one.by_motion[1], one.by_motion[5] / kTurnArm_m};
}

// Order: forward, left, turn times kTurnArm_m; height, roll, pitch.
Vector6d ordered_derivative(const StructureObservation& one) {
  Vector6d ordered;
  ordered << planar(one), one.by_motion.segment<3>(2);
  return ordered;
}

Vector6d descent_of(std::span<const StructureObservation> observations) {
  Vector6d descent = Vector6d::Zero();
  for (const StructureObservation& one : observations) {
    descent -= one.weight_per_m2 * one.residual_m * ordered_derivative(one);
  }
  return descent;
}

Matrix6d sum_of(std::span<const StructureObservation> observations, Matrix6d sum) {
  for (const StructureObservation& one : observations) {
    const Vector6d ordered = ordered_derivative(one);
    sum += one.weight_per_m2 * ordered * ordered.transpose();
  }
  return sum;
}

Matrix6d known_without_surfaces() {
  Matrix6d known = Matrix6d::Zero();
  known(3, 3) = 1.0 / (kFreeHeight_m * kFreeHeight_m);
  known(4, 4) = known(5, 5) = 1.0 / (kFreeTilt_rad * kFreeTilt_rad);
  return known;
}

// Of three motions, columns, by the observations that clearly have a part of them.
Eigen::Vector3d clear_information(std::span<const StructureObservation> observations,
                                  const Eigen::Matrix3d& motions) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const StructureObservation& one : observations) {
    const PlanarMotion by_motion = planar(one);
    const double least = kLeastComponent * std::max(1.0, one.arm_m / kTurnArm_m);
    for (int i = 0; i < 3; ++i) {
      const double part = by_motion.dot(motions.col(i));
      sum[i] += std::abs(part) >= least ? one.weight_per_m2 * part * part : 0.0;
    }
  }
  return sum;
}

// The sum of observations, split into motions in the plane and others.
struct Split {
  Matrix6d sum = Matrix6d::Zero();  // with what is known without surfaces
  // Minus the motion in the plane's derivative by the others: the Schur complement's factor.
  Eigen::Matrix3d followed = Eigen::Matrix3d::Zero();
  SymmetricEigen<3> in_plane;
};

Split split(std::span<const StructureObservation> observations) {
  Split parts;
  parts.sum = sum_of(observations, known_without_surfaces());
  const Eigen::Matrix3d others = parts.sum.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d both = parts.sum.bottomLeftCorner<3, 3>();
  parts.followed = others.llt().solve(both);
  const Eigen::Matrix3d in_plane =
      parts.sum.topLeftCorner<3, 3>() - both.transpose() * parts.followed;
  parts.in_plane = symmetric_eigen<3>(in_plane);
  return parts;
}

Eigen::Vector3d clear_part(const Split& parts, std::span<const StructureObservation> observations) {
  Eigen::Vector3d clear_per_m2 = clear_information(observations, parts.in_plane.vectors);
  clear_per_m2 = clear_per_m2.cwiseMin(parts.in_plane.values).cwiseMax(0.0).eval();
  return clear_per_m2;
}

constexpr int kPlace[] = {0, 1, 5, 2, 3, 4};  // in the usual order

// In the vehicle's level axes, forward, left, up and turns about these, to map axes.
Vector6d to_map(const Vector6d& ordered, const Eigen::Matrix3d& level_axes) {
  Vector6d usual;
  for (int i = 0; i < 6; ++i) usual[kPlace[i]] = (i == 2 ? kTurnArm_m : 1.0) * ordered[i];
  Vector6d result;
  result << level_axes.transpose() * usual.head<3>(), level_axes.transpose() * usual.tail<3>();
  return result;
}

Matrix6d to_map(const Matrix6d& ordered, const Eigen::Matrix3d& level_axes) {
  Matrix6d usual;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      const double scale = (i == 2 ? kTurnArm_m : 1.0) * (j == 2 ? kTurnArm_m : 1.0);
      usual(kPlace[i], kPlace[j]) = scale * 0.5 * (ordered(i, j) + ordered(j, i));
    }
  }
  Matrix6d result;
  for (const int i : {0, 3}) {
    for (const int j : {0, 3}) {
      const Eigen::Matrix3d block = usual.block<3, 3>(i, j) * level_axes;
      result.block<3, 3>(i, j) = level_axes.transpose() * block;
    }
  }
  return 0.5 * (result + result.transpose());
}

}  // namespace

Eigen::Matrix3d level_axes(const Pose& T_map_vehicle) {
  const Eigen::Vector3d forward = T_map_vehicle.linear().col(0);
  const double length = std::max(portable_hypot(forward.x(), forward.y()), 1e-9);
  Eigen::Matrix3d axes;
  axes.row(0) << forward.x() / length, forward.y() / length, 0.0;
  axes.row(1) << -forward.y() / length, forward.x() / length, 0.0;
  axes.row(2) = Eigen::Vector3d::UnitZ();
  return axes;
}

void StructureObserver::begin(const Pose& T_map_vehicle) {
  axes_ = level_axes(T_map_vehicle);
  centre_map_m_ = T_map_vehicle.translation();
  met_.clear();
  order_.clear();
  observations_.clear();
}

// Structures lie far apart in memory: all are prefetched before the first is needed.
void StructureObserver::add_all(const StructureMap& map, std::span<const Eigen::Vector3d> points_m,
                                const Pose& T_map_vehicle) {
  constexpr std::size_t kAhead = 12;
  constexpr std::size_t kMostPoints = 512;
  const std::size_t stride = 1 + points_m.size() / kMostPoints;
  const std::size_t count = (points_m.size() + stride - 1) / stride;
  points_map_m_.resize(count);
  cells_.resize(count);
  numbers_.resize(count);
  for (std::size_t i = 0; i < count; ++i) points_map_m_[i] = T_map_vehicle * points_m[i * stride];
  cell_keys(points_map_m_, map.cell_m(), cells_);
  for (std::size_t i = 0; i < count; ++i) {
    if (i + kAhead < count) map.prefetch(cells_[i + kAhead]);
    numbers_[i] = map.number_of(cells_[i]);
    if (numbers_[i] != StructureMap::kNone) map.prefetch(numbers_[i]);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (numbers_[i] == StructureMap::kNone) continue;
    add(cells_[i], points_map_m_[i], [&]() -> const Structure& { return map.at(numbers_[i]); });
  }
}

// The points of a cell share its normal, so their mean derivative is that of their mean.
void StructureObserver::observe(const Met& met, const Eigen::Vector3d& direction,
                                double variance_m2) {
  const Eigen::Vector3d normal = axes_ * direction;
  const Eigen::Vector3d arm_m = met.sum_m / met.count;
  StructureObservation one;
  one.by_motion << normal, arm_m.cross(normal);
  one.residual_m = normal.dot(arm_m) - direction.dot(met.structure.mean_m - centre_map_m_);
  one.arm_m = one.by_motion.tail<3>().norm();
  one.weight_per_m2 =
      1.0 / (met.structure.shared_m2 + (variance_m2 + kReturnNoise_m * kReturnNoise_m) / met.count);
  observations_.push_back(one);
}

std::span<const StructureObservation> StructureObserver::finish() {
  for (const std::uint32_t number : order_) {
    const Met& met = met_.values()[number];
    if (met.structure.direction_count == 2) {
      observe(met, met.structure.across, met.structure.across_m2);
    }
    observe(met, met.structure.normal, met.structure.normal_m2);
  }
  return observations_;
}

// With L the matrix that eliminates the other motions, L (M + known) L^T = diag(S, D). A
// contraction of S, C = V diag(r) V^T, is applied as U^T M U with U^T = L^-1 diag(C, I) L: the
// result is never indefinite, and its Schur complement is C S C.
StructureEvidence structure_evidence(std::span<const StructureObservation> observations,
                                     const Eigen::Matrix3d& level_axes) {
  const Split parts = split(observations);
  const Eigen::Vector3d clear_per_m2 = clear_part(parts, observations);
  Eigen::Vector3d lost;  // r - 1
  for (int i = 0; i < 3; ++i) {
    const double whole = parts.in_plane.values[i];
    lost[i] = whole > clear_per_m2[i] ? std::sqrt(clear_per_m2[i] / whole) - 1.0 : 0.0;
  }
  const Eigen::Matrix3d scaled = parts.in_plane.vectors * lost.asDiagonal();
  const Eigen::Matrix3d less = scaled * parts.in_plane.vectors.transpose();
  Matrix6d reduce = Matrix6d::Identity();
  reduce.topLeftCorner<3, 3>() += less;
  reduce.topRightCorner<3, 3>() = -less * parts.followed.transpose();
  const Matrix6d half = reduce * (parts.sum - known_without_surfaces());
  const Matrix6d reduced = half * reduce.transpose();
  const Vector6d descent = reduce * descent_of(observations);
  return {to_map(reduced, level_axes), to_map(descent, level_axes)};
}

StructureEvidence structure_evidence(const StructureMap& map,
                                     std::span<const Eigen::Vector3d> points_m,
                                     const Pose& T_map_vehicle, StructureObserver& memory) {
  memory.begin(T_map_vehicle);
  memory.add_all(map, points_m, T_map_vehicle);
  return structure_evidence(memory.finish(), memory.axes());
}

}  // namespace sightline

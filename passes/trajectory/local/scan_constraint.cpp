#include "passes/trajectory/local/scan_constraint.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "formats/base/portable_math.h"
#include "formats/symmetric_eigen.h"

// The information of a match, from the planes and lines that its points meet (Censi, "An accurate
// closed-form estimate of ICP's covariance", ICRA 2007; Tuna et al., "X-ICP", T-RO 2023, from which
// the limit on small components of normals comes). Scores, overlaps and residuals measure agreement
// instead: in a smooth tunnel they are best where a scan's rings meet the rings of the last one,
// however far the vehicle moved.

namespace sightline {
namespace {

// Along a road, rings and noise seem to hold a scan to some centimetres where nothing does.
constexpr double kStartAhead_m = 0.1;
constexpr double kStartAside_m = 0.3;

// Of motions in the plane, 1/m^2, with height, roll and pitch eliminated (Schur complement).
Eigen::Matrix3d planar_information(const std::vector<MetSurface>& surfaces) {
  Matrix6d sum = Matrix6d::Zero();
  sum(3, 3) = 1.0 / (kFreeHeight_m * kFreeHeight_m);
  sum(4, 4) = sum(5, 5) = 1.0 / (kFreeTilt_rad * kFreeTilt_rad);
  for (const MetSurface& one : surfaces) {
    sum += one.weight_per_m2 * one.by_motion * one.by_motion.transpose();
  }
  const Eigen::Matrix3d others = sum.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d both = sum.bottomLeftCorner<3, 3>();
  return sum.topLeftCorner<3, 3>() - both.transpose() * others.llt().solve(both);
}

// Of one motion, by the surfaces that clearly hold it.
double clear_information(const std::vector<MetSurface>& surfaces, const PlanarMotion& motion,
                         HoldRule rule) {
  double sum = 0.0;
  for (const MetSurface& one : surfaces) {
    const double part = one.part(motion);
    if (rule == HoldRule::kClear ? one.clearly_holds(motion) : one.holds(motion))
      sum += one.weight_per_m2 * part * part;
  }
  return sum;
}

}  // namespace

std::vector<PlanarMotion> ScanConstraint::weak_motions(double most_m) const {
  std::vector<PlanarMotion> weak;
  for (int i = 0; i < 3; ++i) {
    if (sigma_m[i] > most_m) weak.emplace_back(motions.col(i));
  }
  return weak;
}

Eigen::Matrix3d ScanConstraint::weak_part(double most_m) const {
  Eigen::Matrix3d projector = Eigen::Matrix3d::Zero();
  for (const PlanarMotion& motion : weak_motions(most_m)) {
    projector += motion * motion.transpose();
  }
  return projector;
}

Eigen::Vector3d ScanConstraint::weak_axes(double most_m) const {
  Eigen::Vector3d square = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    if (sigma_m[i] > most_m) square += motions.col(i).cwiseAbs2();
  }
  return square.cwiseSqrt();
}

ScanConstraint scan_constraint(const std::vector<MetSurface>& surfaces, HoldRule rule) {
  constexpr double kLeast_per_m2 = 1e-4;  // 100 m
  const SymmetricEigen<3> eigen = symmetric_eigen<3>(planar_information(surfaces));
  ScanConstraint found;
  for (int i = 0; i < 3; ++i) {
    const PlanarMotion motion = eigen.vectors.col(i);
    const double clear_per_m2 = clear_information(surfaces, motion, rule);
    found.motions.col(i) = motion;
    found.sigma_m[i] =
        1.0 / std::sqrt(std::max({kLeast_per_m2, std::min(eigen.values[i], clear_per_m2)}));
  }
  return found;
}

Eigen::Vector3d kept_shares(const ScanConstraint& constraint) {
  Eigen::Vector3d kept = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const double start_m = axis == 0 ? kStartAhead_m : kStartAside_m;
    for (int i = 0; i < 3; ++i) {
      const double variance_m2 = constraint.sigma_m[i] * constraint.sigma_m[i];
      const double part = constraint.motions(axis, i);
      kept[axis] += part * part * variance_m2 / (variance_m2 + start_m * start_m);
    }
  }
  return kept;
}

PlanarMotion planar_motion(const Pose& T_map_from, const Pose& T_map_to) {
  const Eigen::Vector3d forward = T_map_from.linear().col(0);
  const Eigen::Vector3d forward_to = T_map_to.linear().col(0);
  const Eigen::Vector3d moved_m = T_map_to.translation() - T_map_from.translation();
  const double length = std::max(portable_hypot(forward.x(), forward.y()), 1e-9);
  const double along_m = (forward.x() * moved_m.x() + forward.y() * moved_m.y()) / length;
  const double left_m = (forward.x() * moved_m.y() - forward.y() * moved_m.x()) / length;
  const double turn_rad =
      portable_atan2(forward.x() * forward_to.y() - forward.y() * forward_to.x(),
                     forward.x() * forward_to.x() + forward.y() * forward_to.y());
  return {along_m, left_m, kTurnArm_m * turn_rad};
}

Pose moved_in_plane(const Pose& T_map_vehicle, const PlanarMotion& motion) {
  LevelMotion level = LevelMotion::Zero();
  level.head<3>() = motion;
  return moved_level(T_map_vehicle, level);
}

}  // namespace sightline

#include "passes/trajectory/local/scan_constraint.h"

#include <algorithm>
#include <cmath>

#include "formats/base/portable_math.h"

// Scores, overlaps and residuals measure agreement instead: in a smooth tunnel they are best where
// a scan's rings meet the rings of the last one, however far the vehicle moved.

namespace sightline {

Eigen::Matrix3d ScanConstraint::weak_part(double most_m) const {
  Eigen::Matrix3d projector = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    if (sigma_m[i] > most_m) projector += motions.col(i) * motions.col(i).transpose();
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

ScanConstraint scan_constraint(const LocalGrids& grids,
                               const std::vector<Eigen::Vector3d>& points_m,
                               const Pose& T_map_lidar, const Pose& T_lidar_vehicle) {
  constexpr double kLeast_per_m2 = 1e-4;  // 100 m
  StructureObserver observer;
  observer.begin(T_map_lidar * T_lidar_vehicle);
  const auto nd_at = [&](const CellKey& key) { return grids.fine_nd(key); };
  for (const Eigen::Vector3d& point_m : points_m) {
    const Eigen::Vector3d point_map_m = T_map_lidar * point_m;
    const Nd* const nd = grids.fine_nd_at(point_map_m);
    if (nd == nullptr) continue;
    observer.add(nd->key, point_map_m, [&] { return structure_of(*nd, nd_at); });
  }
  const PlanarInformation found = planar_information(observer.finish());
  ScanConstraint constraint;
  constraint.motions = found.motions;
  for (int i = 0; i < 3; ++i) {
    constraint.sigma_m[i] = 1.0 / std::sqrt(std::max(kLeast_per_m2, found.information_per_m2[i]));
  }
  return constraint;
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
  const Eigen::Vector3d forward = T_map_vehicle.linear().col(0);
  const double length = std::max(portable_hypot(forward.x(), forward.y()), 1e-9);
  const Eigen::Vector3d ahead(forward.x() / length, forward.y() / length, 0.0);
  const Eigen::Vector3d left(-ahead.y(), ahead.x(), 0.0);
  Pose moved = T_map_vehicle;
  moved.translation() += motion.x() * ahead + motion.y() * left;
  moved.linear() =
      rotation_matrix({Eigen::Vector3d::UnitZ(), motion.z() / kTurnArm_m}) * T_map_vehicle.linear();
  return moved;
}

}  // namespace sightline

#include "passes/trajectory/local/scan_constraint.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "formats/base/portable_math.h"
#include "formats/symmetric_eigen.h"
#include "passes/matching/match_score.h"

// The information of a match, from the planes and lines that its points meet (Censi, "An accurate
// closed-form estimate of ICP's covariance", ICRA 2007; Tuna et al., "X-ICP", T-RO 2023, from which
// the limit on small components of normals comes). Scores, overlaps and residuals measure agreement
// instead: in a smooth tunnel they are best where a scan's rings meet the rings of the last one,
// however far the vehicle moved.

namespace sightline {
namespace {

// Error of a surface that does not average out over its points, and noise of a return.
constexpr double kSurface_m = 0.03;
constexpr double kNoise_m = 0.02;
// A normal's component below this along a motion is noise: sin(10 degrees).
constexpr double kLeastComponent = 0.17;
// A surface is so many times wider than thick, and this wide: rings of one wall are narrower.
constexpr double kLeastWidth = 3.0;
constexpr double kLeastWidth_m = 0.06;
// A line's axis is upright, and it is no thicker than a trunk.
constexpr double kUpright = 0.7;
constexpr double kThickest_m = 0.25;
// A line this near the plane of the next cell is the end of a wall, cut off by its cell.
constexpr double kOnSurface_m = 0.15;
// Points farther from their surface belong to something else.
constexpr double kFarthest_m = 0.25;
// What is known of height, roll and pitch without any surface.
constexpr double kHeight_m = 1.0;
constexpr double kTilt_rad = 0.1;

// One observation: its derivative by a motion (forward, left, up; roll, pitch, turn), and weight.
struct Observation {
  Vector6d by_motion = Vector6d::Zero();
  double weight_per_m2 = 0.0;
};

// The points of a scan in one cell.
struct MetCell {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();  // of the points, in the vehicle's axes
  double count = 0.0;
};

// Whether a line is the end of a surface of a cell beside it.
bool ends_surface(const LocalGrids& grids, const Nd& line) {
  for (std::int32_t x = -1; x <= 1; ++x) {
    for (std::int32_t y = -1; y <= 1; ++y) {
      if (x == 0 && y == 0) continue;
      const Nd* beside = grids.fine_nd({line.key.x + x, line.key.y + y, line.key.z});
      if (beside == nullptr || !is_surface(*beside)) continue;
      const Eigen::Vector3d normal = beside->eigenvectors.col(2);
      if (std::abs(normal.dot(line.mean_m - beside->mean_m)) < kOnSurface_m) return true;
    }
  }
  return false;
}

class Observer {
 public:
  Observer(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
           const Pose& T_map_lidar, const Pose& T_lidar_vehicle)
      : grids_(grids), T_map_vehicle_(T_map_lidar * T_lidar_vehicle) {
    const Eigen::Vector3d forward = T_map_vehicle_.linear().col(0);
    const double length = std::max(portable_hypot(forward.x(), forward.y()), 1e-9);
    axes_.row(0) << forward.x() / length, forward.y() / length, 0.0;
    axes_.row(1) << -forward.y() / length, forward.x() / length, 0.0;
    axes_.row(2) = Eigen::Vector3d::UnitZ();
    meet(points_m, T_map_lidar);
    for (std::size_t i = 0; i < met_.keys().size(); ++i) observe(nds_[i], met_.values()[i]);
  }

  [[nodiscard]] const std::vector<Observation>& observations() const { return observations_; }

 private:
  void meet(const std::vector<Eigen::Vector3d>& points_m, const Pose& T_map_lidar) {
    for (const Eigen::Vector3d& point_m : points_m) {
      const Eigen::Vector3d point_map_m = T_map_lidar * point_m;
      const Nd* nd = grids_.fine_nd_at(point_map_m);
      if (nd == nullptr) continue;
      const Eigen::Vector3d normal = nd->eigenvectors.col(2);
      if (std::abs(normal.dot(point_map_m - nd->mean_m)) > kFarthest_m) continue;
      const CellTable<MetCell>::Inserted cell = met_.insert(nd->key);
      if (cell.is_new) nds_.push_back(nd);
      MetCell& met = met_.values()[cell.number];
      met.sum_m += axes_ * (point_map_m - T_map_vehicle_.translation());
      met.count += 1.0;
    }
  }

  void observe(const Nd* nd, const MetCell& met) {
    if (is_surface(*nd)) {
      add(*nd, 2, met);
    } else if (is_upright_line(*nd) && !ends_surface(grids_, *nd)) {
      add(*nd, 1, met);
      add(*nd, 2, met);
    }
  }

  // Along one axis of the ND. The points of a cell share its normal, so their mean derivative is
  // that of their mean.
  void add(const Nd& nd, int axis, const MetCell& met) {
    const Eigen::Vector3d normal = axes_ * nd.eigenvectors.col(axis);
    const Eigen::Vector3d arm_m = met.sum_m / met.count;
    Observation one;
    one.by_motion << normal, arm_m.cross(normal);
    one.weight_per_m2 = 1.0 / (kSurface_m * kSurface_m +
                               (nd.eigenvalues_m2[axis] + kNoise_m * kNoise_m) / met.count);
    observations_.push_back(one);
  }

  const LocalGrids& grids_;
  Pose T_map_vehicle_;
  Eigen::Matrix3d axes_ = Eigen::Matrix3d::Identity();  // rows: the vehicle's, level
  CellTable<MetCell> met_;
  std::vector<const Nd*> nds_;  // of the cells that are met
  std::vector<Observation> observations_;
};

PlanarMotion planar(const Observation& one) {
  return {one.by_motion[0], one.by_motion[1], one.by_motion[5] / kTurnArm_m};
}

// Of motions in the plane, 1/m^2, with height, roll and pitch eliminated (Schur complement).
Eigen::Matrix3d planar_information(const std::vector<Observation>& observations) {
  Matrix6d sum = Matrix6d::Zero();  // forward, left, turn; height, roll, pitch
  sum(3, 3) = 1.0 / (kHeight_m * kHeight_m);
  sum(4, 4) = sum(5, 5) = 1.0 / (kTilt_rad * kTilt_rad);
  for (const Observation& one : observations) {
    Vector6d ordered;
    ordered << planar(one), one.by_motion.segment<3>(2);
    sum += one.weight_per_m2 * ordered * ordered.transpose();
  }
  const Eigen::Matrix3d others = sum.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d both = sum.bottomLeftCorner<3, 3>();
  return sum.topLeftCorner<3, 3>() - both.transpose() * others.llt().solve(both);
}

// Of one motion, by the observations that clearly have a part of it.
double clear_information(const std::vector<Observation>& observations, const PlanarMotion& motion) {
  double sum = 0.0;
  for (const Observation& one : observations) {
    const PlanarMotion by_motion = planar(one);
    const double arm_m =
        portable_hypot(one.by_motion[3], portable_hypot(one.by_motion[4], one.by_motion[5]));
    const double part = by_motion.dot(motion);
    const double least = kLeastComponent * std::max(1.0, arm_m / kTurnArm_m);
    if (std::abs(part) >= least) sum += one.weight_per_m2 * part * part;
  }
  return sum;
}

}  // namespace

bool is_surface(const Nd& nd) {
  const double width_m = std::sqrt(nd.eigenvalues_m2[1]);
  return width_m >= kLeastWidth_m && width_m >= kLeastWidth * std::sqrt(nd.eigenvalues_m2[2]);
}

bool is_upright_line(const Nd& nd) {
  return dimension_class(nd) == 1 && std::abs(nd.eigenvectors(2, 0)) > kUpright &&
         std::sqrt(nd.eigenvalues_m2[1]) <= kThickest_m;
}

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
  const Observer observer(grids, points_m, T_map_lidar, T_lidar_vehicle);
  const Eigen::Matrix3d information_per_m2 = planar_information(observer.observations());
  const SymmetricEigen<3> eigen = symmetric_eigen<3>(information_per_m2);
  ScanConstraint found;
  for (int i = 0; i < 3; ++i) {
    const PlanarMotion motion = eigen.vectors.col(i);
    const double clear_per_m2 = clear_information(observer.observations(), motion);
    found.motions.col(i) = motion;
    found.sigma_m[i] =
        1.0 / std::sqrt(std::max({kLeast_per_m2, std::min(eigen.values[i], clear_per_m2)}));
  }
  return found;
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

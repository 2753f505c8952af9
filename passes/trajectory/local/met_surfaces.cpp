#include "passes/trajectory/local/met_surfaces.h"

#include <algorithm>
#include <cmath>

#include "formats/base/portable_math.h"
#include "formats/grid/cell_index.h"
#include "passes/matching/covariance/structure.h"

namespace sightline {
namespace {

// Error of a surface that does not average out over its points.
constexpr double kSurface_m = 0.03;
// Points farther from their surface belong to something else.
constexpr double kFarthest_m = 0.25;
// An axis holds a motion by more than so many standard deviations of its own noise, and at least by
// kLeastComponent, below which errors of the map's poses bend surfaces.
constexpr double kClearSigmas = 3.0;
// What several objects fill, or one that moves, is thicker.
constexpr double kThin_m = 0.06;

// The points of a scan in one cell.
struct MetCell {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();      // from the vehicle, in its level axes
  Eigen::Vector3d sum_map_m = Eigen::Vector3d::Zero();  // from the mean of the ND, map axes
  double count = 0.0;
};

// Whether a line is the end of a surface of a cell beside it.
bool ends_surface_in(const RollingCells& cells, const Nd& line) {
  for (std::int32_t x = -1; x <= 1; ++x) {
    for (std::int32_t y = -1; y <= 1; ++y) {
      if (x == 0 && y == 0) continue;
      const Nd* beside = cells.nd({line.key.x + x, line.key.y + y, line.key.z});
      if (beside != nullptr && ends_surface(line, *beside)) return true;
    }
  }
  return false;
}

// Of an axis of an ND by noise of its returns, map axes: towards each other axis the variance of
// the axis's own deviation over that of the other one and the number of returns.
Eigen::Matrix3d axis_covariance(const Nd& nd, int axis) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  const double across_m2 = nd.eigenvalues_m2[axis] + kReturnNoise_m * kReturnNoise_m;
  for (int other = 0; other < 3; ++other) {
    if (other == axis) continue;
    const Eigen::Vector3d towards = nd.eigenvectors.col(other);
    const double variance = across_m2 / (nd.point_count * std::max(nd.eigenvalues_m2[other], 1e-6));
    covariance += std::min(variance, 1.0) * towards * towards.transpose();
  }
  return covariance;
}

class Meeting {
 public:
  Meeting(const RollingCells& cells, const Pose& T_map_vehicle)
      : cells_(cells), at_map_m_(T_map_vehicle.translation()), axes_(level_axes(T_map_vehicle)) {}

  // Whether the point meets a surface or an upright line.
  bool take(const Eigen::Vector3d& point_map_m) {
    const Nd* nd = cells_.nd(cell_key(point_map_m, cells_.cell_m()));
    if (nd == nullptr || !(is_surface(*nd) || is_upright_line(*nd))) return false;
    const Eigen::Vector3d off_m = point_map_m - nd->mean_m;
    const Eigen::Vector3d normal = nd->eigenvectors.col(2);
    if (std::abs(normal.dot(off_m)) > kFarthest_m) return false;
    const CellTable<MetCell>::Inserted cell = met_.insert(nd->key);
    if (cell.is_new) nds_.push_back(nd);
    MetCell& met = met_.values()[cell.number];
    met.sum_m += axes_ * (point_map_m - at_map_m_);
    met.sum_map_m += off_m;
    met.count += 1.0;
    return true;
  }

  [[nodiscard]] std::vector<MetSurface> surfaces() const {
    std::vector<MetSurface> found;
    for (std::size_t i = 0; i < nds_.size(); ++i) {
      const Nd& nd = *nds_[i];
      const MetCell& met = met_.values()[i];
      if (is_surface(nd)) {
        found.push_back(along(nd, 2, met));
      } else if (is_upright_line(nd) && !ends_surface_in(cells_, nd)) {
        found.push_back(along(nd, 1, met));
        found.push_back(along(nd, 2, met));
      }
    }
    return found;
  }

 private:
  // The points of a cell share its normal, so their mean derivative is that of their mean.
  [[nodiscard]] MetSurface along(const Nd& nd, int axis, const MetCell& met) const {
    MetSurface one;
    const Eigen::Vector3d normal_map = nd.eigenvectors.col(axis);
    const Eigen::Vector3d normal = axes_ * normal_map;
    one.arm_m = met.sum_m / met.count;
    const Eigen::Vector3d by_turn = one.arm_m.cross(normal);
    one.by_motion << normal.x(), normal.y(), by_turn.z() / kTurnArm_m, normal.z(), by_turn.x(),
        by_turn.y();
    one.distance_m = normal_map.dot(met.sum_map_m) / met.count;
    const double surface_m = kSurface_m / cells_.cell_m();  // so that the sum over a wall is one
    one.weight_per_m2 =
        1.0 / (surface_m * surface_m +
               (nd.eigenvalues_m2[axis] + kReturnNoise_m * kReturnNoise_m) / met.count);
    one.deviation_m = std::sqrt(nd.eigenvalues_m2[axis]);
    one.is_lasting = cells_.is_lasting(nd.key);
    one.axis_covariance = axes_ * axis_covariance(nd, axis) * axes_.transpose();
    return one;
  }

  const RollingCells& cells_;
  Eigen::Vector3d at_map_m_;
  Eigen::Matrix3d axes_;
  CellTable<MetCell> met_;
  std::vector<const Nd*> nds_;  // of the cells that are met
};

}  // namespace

bool MetSurface::holds(const PlanarMotion& motion) const {
  const double arm =
      portable_hypot(by_motion[2] * kTurnArm_m, portable_hypot(by_motion[4], by_motion[5]));
  return std::abs(part(motion)) >= kLeastComponent * std::max(1.0, arm / kTurnArm_m);
}

bool MetSurface::clearly_holds(const PlanarMotion& motion) const {
  if (!is_lasting || deviation_m > kThin_m || !holds(motion)) return false;
  // The derivative of the part by the axis.
  const double turn = motion.z() / kTurnArm_m;
  const Eigen::Vector3d by_axis(motion.x() - turn * arm_m.y(), motion.y() + turn * arm_m.x(), 0.0);
  return std::abs(part(motion)) >= kClearSigmas * std::sqrt(by_axis.dot(axis_covariance * by_axis));
}

Pose moved_level(const Pose& T_map_vehicle, const LevelMotion& motion) {
  const Eigen::Matrix3d to_map = level_axes(T_map_vehicle).transpose();
  const Eigen::Vector3d shift_m(motion[0], motion[1], motion[3]);
  const Eigen::Vector3d turn_rad(motion[4], motion[5], motion[2] / kTurnArm_m);
  Pose moved = T_map_vehicle;
  moved.translation() += to_map * shift_m;
  const double angle_rad = turn_rad.norm();
  if (angle_rad > 0.0) {
    const Eigen::Vector3d axis = to_map * (turn_rad / angle_rad);
    moved.linear() = rotation_matrix({axis, angle_rad}) * T_map_vehicle.linear();
  }
  return moved;
}

std::vector<MetSurface> met_surfaces(std::span<const RollingCells* const> grids,
                                     const std::vector<Eigen::Vector3d>& points_m,
                                     const Pose& T_map_lidar, const Pose& T_lidar_vehicle) {
  const Pose T_map_vehicle = T_map_lidar * T_lidar_vehicle;
  std::vector<Meeting> meetings;
  for (const RollingCells* cells : grids) meetings.emplace_back(*cells, T_map_vehicle);
  for (const Eigen::Vector3d& point_m : points_m) {
    const Eigen::Vector3d point_map_m = T_map_lidar * point_m;
    for (Meeting& meeting : meetings) {
      if (meeting.take(point_map_m)) break;
    }
  }
  std::vector<MetSurface> all;
  for (const Meeting& meeting : meetings) {
    const std::vector<MetSurface> found = meeting.surfaces();
    all.insert(all.end(), found.begin(), found.end());
  }
  return all;
}

std::vector<MetSurface> met_surfaces(const LocalGrids& grids,
                                     const std::vector<Eigen::Vector3d>& points_m,
                                     const Pose& T_map_lidar, const Pose& T_lidar_vehicle) {
  const RollingCells* const fine[] = {&grids.fine_cells()};
  return met_surfaces(fine, points_m, T_map_lidar, T_lidar_vehicle);
}

}  // namespace sightline

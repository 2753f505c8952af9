#include "passes/matching/covariance/structure_information.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

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
  Vector6d descent = Vector6d::Zero();
  // Minus the motion in the plane's derivative by the others: the Schur complement's factor.
  Eigen::Matrix3d followed = Eigen::Matrix3d::Zero();
  SymmetricEigen<3> in_plane;
};

Split split(std::span<const StructureObservation> observations) {
  Split parts;
  parts.sum = known_without_surfaces();
  for (const StructureObservation& one : observations) {
    const Vector6d ordered = ordered_derivative(one);
    const Vector6d weighted = one.weight_per_m2 * ordered;
    parts.sum.noalias() += weighted * ordered.transpose();
    parts.descent -= one.residual_m * weighted;
  }
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

// Of observations in sum. Turns count as what they move at kTurnArm_m.
bool holds_every_motion(const Matrix6d& observed) {
  constexpr double kRounding = 1e-12;
  Vector6d scale;
  scale << 1.0, 1.0, 1.0, 1.0, 1.0 / kTurnArm_m, 1.0 / kTurnArm_m;
  const Matrix6d scaled = scale.asDiagonal() * observed * scale.asDiagonal();
  const Vector6d pivots = Eigen::LDLT<Matrix6d>(scaled).vectorD();
  return pivots.minCoeff() > kRounding * pivots.maxCoeff();
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

void StructureObserver::begin(const StructureMap& map, const Pose& T_map_vehicle) {
  map_ = &map;
  axes_ = level_axes(T_map_vehicle);
  centre_map_m_ = T_map_vehicle.translation();
  met_.clear();
  raised_ = {};
  observations_.clear();
  if (place_of_.size() < map.size()) place_of_.resize(map.size(), 0);
}

bool StructureObserver::add(std::uint32_t number, const Eigen::Vector3d& point_map_m) {
  const Structure& structure = map_->at(number);
  const double off_m = structure.normal.dot(point_map_m - structure.mean_m);
  if (std::abs(off_m) > structure.farthest_m) return false;
  std::uint32_t& place = place_of_[number];
  if (place >= met_.size() || met_[place].structure != number) {
    place = static_cast<std::uint32_t>(met_.size());
    met_.push_back({number, 0.0, Eigen::Vector3d::Zero()});
  }
  Met& met = met_[place];
  met.sum_m += point_map_m - centre_map_m_;
  met.count += 1.0;
  return true;
}

void StructureObserver::add_point(std::uint32_t number, const Eigen::Vector3d& point_map_m) {
  constexpr double kHorizontal = 0.7;  // of a normal
  bool is_met = number == StructureMap::kConstrainsNothing;
  if (StructureMap::is_structure(number)) {
    is_met = add(number, point_map_m);
    if (std::abs(map_->at(number).normal.z()) > kHorizontal) return;
  }
  ++raised_.count;
  raised_.met_count += is_met ? 1 : 0;
}

// The matcher's last pose was a step away, if it was of this climb at all: its cell of a point
// holds where the point is still in it.
void StructureObserver::find_records(const ScanForMatch& scan, const Pose& T_map_vehicle) {
  constexpr std::size_t kMostPoints = 512;
  const MatchGrid& grid = map_->grid();
  const bool is_known = scan.cells_digest == grid.cells_digest;
  const std::size_t stride = 1 + scan.points_m.size() / kMostPoints;
  const std::size_t count = (scan.points_m.size() + stride - 1) / stride;
  points_map_m_.resize(count);
  records_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = i * stride;
    points_map_m_[i] = T_map_vehicle * scan.points_m[k];
    const CellKey cell = cell_key(points_map_m_[i], grid.cell_m);
    const bool is_same = is_known && scan.cell_x[k] == cell.x && scan.cell_y[k] == cell.y &&
                         scan.cell_z[k] == cell.z;
    records_[i] = is_same ? scan.record[k] : record_of_cell(grid, cell);
    map_->prefetch_record(records_[i]);
  }
}

// Structures are far apart in memory: all are prefetched before the first is needed.
void StructureObserver::add_all(const ScanForMatch& scan, const Pose& T_map_vehicle) {
  find_records(scan, T_map_vehicle);
  numbers_.resize(records_.size());
  for (std::size_t i = 0; i < records_.size(); ++i) {
    numbers_[i] = map_->number_of_record(records_[i]);
    if (StructureMap::is_structure(numbers_[i])) map_->prefetch(numbers_[i]);
  }
  for (std::size_t i = 0; i < numbers_.size(); ++i) add_point(numbers_[i], points_map_m_[i]);
}

// The points of a cell share its normal, so their mean derivative is that of their mean.
void StructureObserver::observe(const Met& met, const Eigen::Vector3d& direction,
                                double variance_m2) {
  const Structure& structure = map_->at(met.structure);
  const Eigen::Vector3d mean_m = met.sum_m / met.count;
  const Eigen::Vector3d normal = axes_ * direction;
  const Eigen::Vector3d arm_m = axes_ * mean_m;
  StructureObservation one;
  one.by_motion << normal, arm_m.cross(normal);
  one.residual_m = direction.dot(mean_m + centre_map_m_ - structure.mean_m);
  one.arm_m = one.by_motion.tail<3>().norm();
  one.weight_per_m2 =
      1.0 / (structure.shared_m2 + (variance_m2 + kReturnNoise_m * kReturnNoise_m) / met.count);
  observations_.push_back(one);
}

std::span<const StructureObservation> StructureObserver::finish() {
  for (const Met& met : met_) {
    const Structure& structure = map_->at(met.structure);
    if (structure.direction_count == 2) observe(met, structure.across, structure.across_m2);
    observe(met, structure.normal, structure.normal_m2);
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
  const Matrix6d observed = parts.sum - known_without_surfaces();
  const Matrix6d half = reduce * observed;
  const Matrix6d reduced = half * reduce.transpose();
  const Vector6d descent = reduce * parts.descent;
  return {
      to_map(reduced, level_axes), to_map(descent, level_axes), holds_every_motion(observed), {}};
}

StructureEvidence structure_evidence(const StructureMap& map, const ScanForMatch& scan,
                                     const Pose& T_map_vehicle, StructureObserver& memory) {
  memory.begin(map, T_map_vehicle);
  memory.add_all(scan, T_map_vehicle);
  StructureEvidence evidence = structure_evidence(memory.finish(), memory.axes());
  evidence.raised = memory.raised();
  return evidence;
}

}  // namespace sightline

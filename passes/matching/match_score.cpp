#include "passes/matching/match_score.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "formats/base/check.h"
#include "formats/base/portable_math.h"
#include "formats/symmetric_eigen.h"

// Magnusson's score (The Three-Dimensional Normal-Distributions Transform, 2009, section 6.2). All
// NDs of a point share the point's Jacobian, so their first and second derivatives by the position
// of the point are added up first (3 and 6 numbers) and led to the six of the pose once a point.

namespace sightline {
namespace {

// Of the score of one point by its own position in the map.
struct PointScore {
  double score = 0.0;
  double nearest = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
};

PointScore score_of_point(const MatchGrid& grid, const MatchGrid::Neighbourhood& neighbourhood,
                          const Eigen::Vector3d& point_m) {
  const double d2 = grid.gauss.d2;
  PointScore point;
  for (const std::int32_t index : neighbourhood) {
    if (index == MatchGrid::kNone) continue;
    const MatchNd& nd = grid.nds[static_cast<std::size_t>(index)];
    const Eigen::Vector3d off_m = point_m - nd.mean_m;
    const Eigen::Vector3d pull = nd.information_per_m2 * off_m;
    const double term = -grid.gauss.d1 * portable_exp(-0.5 * d2 * off_m.dot(pull));
    point.score += term;
    point.nearest = std::max(point.nearest, term);
    point.gradient -= (d2 * term) * pull;
    point.hessian -= (d2 * term) * (nd.information_per_m2 - d2 * pull * pull.transpose());
  }
  return point;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

// Chain rule through x = t + dt + exp([w]x) r: dx/dw = -[r]x and d2x/dw_i dw_j =
// (e_i r_j + e_j r_i)/2 - delta_ij r.
void add_point(const PointScore& point, const Eigen::Vector3d& arm_m, MatchScore& total) {
  const Eigen::Matrix3d by_rotation = -cross_matrix(arm_m);
  const Eigen::Matrix3d mixed = point.hessian * by_rotation;
  const Eigen::Matrix3d bend =
      0.5 * (point.gradient * arm_m.transpose() + arm_m * point.gradient.transpose()) -
      point.gradient.dot(arm_m) * Eigen::Matrix3d::Identity();
  total.score += point.score;
  total.nearest_sum += point.nearest;
  total.gradient.head<3>() += point.gradient;
  total.gradient.tail<3>() += arm_m.cross(point.gradient);
  total.hessian.topLeftCorner<3, 3>() += point.hessian;
  total.hessian.topRightCorner<3, 3>() += mixed;
  total.hessian.bottomRightCorner<3, 3>() += by_rotation.transpose() * mixed + bend;
}

}  // namespace

MatchScore match_score(const MatchGrid& grid, std::span<const Eigen::Vector3d> points_m,
                       const Pose& T_map_sensor) {
  const bool is_kept_for_kernels = grid.cells.size() == 0 && grid.records.places.size() > 1;
  SIGHTLINE_CHECK(!is_kept_for_kernels);
  MatchScore total;
  for (const Eigen::Vector3d& point_sensor_m : points_m) {
    const Eigen::Vector3d arm_m = T_map_sensor.linear() * point_sensor_m;
    const Eigen::Vector3d point_m = arm_m + T_map_sensor.translation();
    // int32 keys hold this many cells; farther points have no ND near anyway.
    if (!(point_m.cwiseAbs().maxCoeff() < 0x1.0p30 * grid.cell_m)) continue;
    const std::int32_t cell = find_cell(grid, cell_key(point_m, grid.cell_m));
    if (cell == MatchGrid::kNone) continue;
    ++total.scored_points;
    add_point(score_of_point(grid, grid.neighbourhoods[static_cast<std::size_t>(cell)], point_m),
              arm_m, total);
  }
  // Only the upper triangle is right so far; the lower follows from it.
  total.hessian.triangularView<Eigen::StrictlyLower>() = total.hessian.transpose();
  return total;
}

Pose moved(const Pose& T_map_sensor, const Vector6d& motion) {
  // Series of sin(a/2)/a and cos(a/2), good to the last bit for a below 0.1.
  const Eigen::Vector3d turn = motion.tail<3>();
  const double a2 = turn.squaredNorm();
  const double half_sinc = 0.5 - a2 * (1.0 / 48.0 - a2 * (1.0 / 3840.0 - a2 / 645120.0));
  const double half_cos = 1.0 - a2 * (1.0 / 8.0 - a2 * (1.0 / 384.0 - a2 / 46080.0));
  Eigen::Quaterniond rotation(half_cos, half_sinc * turn.x(), half_sinc * turn.y(),
                              half_sinc * turn.z());
  rotation = rotation * Eigen::Quaterniond(T_map_sensor.linear());
  rotation.normalize();
  Pose pose = Pose::Identity();
  pose.linear() = rotation.toRotationMatrix();
  pose.translation() = T_map_sensor.translation() + motion.head<3>();
  return pose;
}

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

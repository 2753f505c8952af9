#include "passes/factors/information.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/portable_math.h"
#include "formats/symmetric_eigen.h"
#include "passes/matching/grid/match_grid.h"

namespace sightline {
namespace {

struct Sample {
  double distance_m = 0.0;
  std::size_t index = 0;
};

std::vector<Sample> nearest_first(std::span<const Eigen::Vector3d> points_m, double longest_m) {
  std::vector<Sample> samples;
  samples.reserve(points_m.size());
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const double distance_m = points_m[i].norm();
    if (distance_m <= longest_m) samples.push_back({distance_m, i});
  }
  std::sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) {
    return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.index < b.index;
  });
  return samples;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& r) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
  return matrix;
}

void add_point(const Eigen::Vector3d& p_map_m, const Eigen::Vector3d& r_m, const NdtMap& map,
               const MatchGrid& grid, ScanInformation& information) {
  ++information.point_count;
  const std::int32_t index = nd_of_cell(grid, cell_key(p_map_m + r_m, grid.cell_m));
  if (index == MatchGrid::kNone) {
    ++information.unmatched_count;
    return;
  }
  const auto i = static_cast<std::size_t>(index);
  add_sample(r_m, grid.nds[i].information_per_m2, information.pose);
  if (dimension_class(map.nds[i]) != 2) return;
  const Eigen::Vector2d normal = map.nds[i].eigenvectors.col(2).head<2>();
  information.planar_normals += normal * normal.transpose();
}

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

// Block by block.
void add_sample(const Eigen::Vector3d& r_m, const Eigen::Matrix3d& information_per_m2,
                Matrix6d& pose) {
  const Eigen::Matrix3d cross = cross_matrix(r_m);
  const Eigen::Matrix3d A_cross = information_per_m2 * cross;
  pose.topLeftCorner<3, 3>() += information_per_m2;
  pose.topRightCorner<3, 3>() -= A_cross;
  pose.bottomLeftCorner<3, 3>() -= A_cross.transpose();
  pose.bottomRightCorner<3, 3>() += cross.transpose() * A_cross;
}

std::vector<ScanInformation> scan_information(const Eigen::Vector3d& p_map_m,
                                              std::span<const Eigen::Vector3d> points_m,
                                              const NdtMap& map, const MatchGrid& grid,
                                              const std::vector<double>& ranges_m) {
  const std::vector<Sample> samples = nearest_first(points_m, ranges_m.back());
  std::vector<ScanInformation> by_range;
  ScanInformation sum;
  std::size_t next = 0;
  for (const double range_m : ranges_m) {
    for (; next < samples.size() && samples[next].distance_m <= range_m; ++next) {
      add_point(p_map_m, points_m[samples[next].index], map, grid, sum);
    }
    by_range.push_back(sum);
  }
  return by_range;
}

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

double hz_lmin(const Eigen::Matrix2d& planar_normals) {
  const double half_sum = 0.5 * (planar_normals(0, 0) + planar_normals(1, 1));
  const double half_difference = 0.5 * (planar_normals(0, 0) - planar_normals(1, 1));
  return std::max(0.0, half_sum - portable_hypot(half_difference, planar_normals(0, 1)));
}

}  // namespace sightline

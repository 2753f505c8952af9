#include "passes/factors/virtual_scan.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "formats/base/portable_math.h"
#include "formats/base/random.h"
#include "formats/symmetric_eigen.h"
#include "passes/matching/grid/match_grid.h"
#include "passes/matching/match_starts.h"

namespace sightline {
namespace {

using Sample = std::pair<double, std::size_t>;  // distance, m, and index

std::vector<Sample> nearest_first(std::span<const Eigen::Vector3d> points_m, double longest_m) {
  std::vector<Sample> samples;
  samples.reserve(points_m.size());
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const double distance_m = points_m[i].norm();
    if (distance_m <= longest_m) samples.emplace_back(distance_m, i);
  }
  std::ranges::sort(samples);
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

constexpr std::size_t kViews = 4;
constexpr double kHidden_rad = 0.5 * std::numbers::pi;  // of azimuth, in each view
constexpr double kNoise_m = 0.085;                      // the most, each coordinate
constexpr std::uint64_t kNoiseSeed = 0x7669727475616cULL;

// Between two azimuths less than a turn and a half apart. What is more than half a turn lies
// between a half and twice the whole one, so that this difference is exact: std::remainder's, which
// takes far longer.
double angle_between(double a_rad, double b_rad) {
  const double apart_rad = std::abs(a_rad - b_rad);
  return apart_rad <= std::numbers::pi ? apart_rad : std::abs(2.0 * std::numbers::pi - apart_rad);
}

// What a view shows: as if something large stood near, on another side in each.
void see_disturbed(const VirtualPlace& place, std::span<const double> azimuths_rad,
                   std::size_t view, std::vector<Eigen::Vector3d>& seen_m) {
  const double hidden_rad =
      2.0 * std::numbers::pi * static_cast<double>(view) / static_cast<double>(kViews);
  Random random(mix(kNoiseSeed, view));
  seen_m.clear();
  for (std::size_t i = 0; i < place.points_m.size(); ++i) {
    Eigen::Vector3d noise_m;
    for (double& coordinate_m : noise_m) coordinate_m = random.uniform(-kNoise_m, kNoise_m);
    if (angle_between(azimuths_rad[i], hidden_rad) > 0.5 * kHidden_rad) {
      seen_m.emplace_back(place.points_m[i] + noise_m);
    }
  }
}

double rival_score(const Localizer& localizer, const VirtualPlace& place, ScanForMatch& scan) {
  constexpr double kStep_m = 0.25;
  constexpr int kNearest = 2;  // steps
  constexpr int kFarthest = 10;
  const SinCos heading = portable_sin_cos(place.loose_heading_deg * std::numbers::pi / 180.0);
  const auto score_at = [&](int steps) {
    Pose T_map_scan = Pose::Identity();
    T_map_scan.translation() =
        place.p_map_m + steps * kStep_m * Eigen::Vector3d(heading.cos, heading.sin, 0.0);
    return kernel_score_alone(*localizer.levels.front().grid, scan, scan.thin_count, T_map_scan,
                              MatchKernel::kFastest);
  };
  const double here = score_at(0);
  if (!(here > 0.0)) return 1.0;
  // First to one side, then to the other: from one step to the next few points change their cell.
  double best = 0.0;
  for (const int side : {1, -1}) {
    for (int steps = kNearest; steps <= kFarthest; ++steps) {
      best = std::max(best, score_at(side * steps));
    }
  }
  return best / here;
}

}  // namespace

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
    for (; next < samples.size() && samples[next].first <= range_m; ++next) {
      add_point(p_map_m, points_m[samples[next].second], map, grid, sum);
    }
    by_range.push_back(sum);
  }
  return by_range;
}

Crlb crlb(const Matrix6d& information) {
  Matrix6d posterior = information;
  for (int i = 0; i < 3; ++i) {
    posterior(i, i) += 1.0 / (kPriorPosition_m * kPriorPosition_m);
    posterior(i + 3, i + 3) += 1.0 / (kPriorAngle_rad * kPriorAngle_rad);
  }
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

VirtualMatch virtual_match(const Localizer& localizer, const VirtualPlace& place) {
  const std::vector<InitialOffset> offsets = initial_offsets(StartPattern{});
  std::vector<double> azimuths_rad;
  for (const Eigen::Vector3d& point_m : place.points_m) {
    azimuths_rad.push_back(portable_atan2(point_m.y(), point_m.x()));
  }
  VirtualMatch result;
  std::vector<Eigen::Vector3d> seen_m;
  ScanForMatch scan;
  SharedClimbs climbs;
  for (std::size_t view = 0; view < kViews; ++view) {
    see_disturbed(place, azimuths_rad, view, seen_m);
    fill_scan_for_match(seen_m, lead_stride(localizer, seen_m.size()), scan);
    climbs.clear();
    for (std::size_t k = view; k < offsets.size(); k += kViews) {
      // The scan's axes are the map's: the start is turned by the yaw alone.
      Pose T_map_start = start_pose(offsets[k]);
      T_map_start.translation() = place.p_map_m + place.R_map_vehicle * T_map_start.translation();
      const MatchResult found = localize(localizer, scan, T_map_start, {}, &climbs);
      result.error_m += (found.T_map_sensor.translation() - place.p_map_m).norm() /
                        static_cast<double>(offsets.size());
    }
  }
  fill_scan_for_match(place.points_m, lead_stride(localizer, place.points_m.size()), scan);
  result.rival_score = rival_score(localizer, place, scan);
  return result;
}

}  // namespace sightline

#include "passes/map/scan_rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/portable_math.h"

// Rays lie in bins of direction, rows by elevation and columns by azimuth. A query asks the bins
// that its cone touches: a handful, where walking every ray through space asks every voxel on the
// way.

namespace sightline {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kColumns = 720;
constexpr int kRows = 180;
constexpr double kColumn_rad = 2.0 * kPi / kColumns;
constexpr double kRow_rad = kPi / kRows;

struct Direction {
  double azimuth_rad = 0.0;    // from 0 to 2 pi
  double elevation_rad = 0.0;  // from 0 (straight down) to pi
};

Direction direction_of(const Eigen::Vector3d& p) {
  return {portable_atan2(p.y(), p.x()) + kPi,
          portable_atan2(p.z(), p.head<2>().norm()) + 0.5 * kPi};
}

int row_of(double elevation_rad) {
  return std::clamp(static_cast<int>(elevation_rad / kRow_rad), 0, kRows - 1);
}

int column_of(double azimuth_rad) {
  return std::clamp(static_cast<int>(azimuth_rad / kColumn_rad), 0, kColumns - 1);
}

struct ColumnRange {
  int first = 0;  // may be below 0: azimuth goes round
  int count = kColumns;
};

// A cone of half angle c at elevation e reaches asin(sin c / cos e) to either side. For directions
// that pass a point within touch_m both are lengths over its distance: touch_m, and how far it is
// from the vertical axis.
ColumnRange columns_around(const Direction& middle, double from_axis_m, double touch_m) {
  if (!(touch_m < from_axis_m)) return {};
  const double side_rad = portable_asin(touch_m / from_axis_m);
  const int first = static_cast<int>(std::floor((middle.azimuth_rad - side_rad) / kColumn_rad));
  const int last = static_cast<int>(std::floor((middle.azimuth_rad + side_rad) / kColumn_rad));
  return {first, std::min(last - first + 1, kColumns)};
}

}  // namespace

ScanRays::ScanRays(std::span<const Eigen::Vector3d> points_lidar_m)
    : rays_(points_lidar_m.size()), begin_(kRows * kColumns + 1, 0) {
  std::vector<std::uint32_t> bins;
  bins.reserve(points_lidar_m.size());
  for (const Eigen::Vector3d& point_m : points_lidar_m) {
    const Direction direction = direction_of(point_m);
    const int bin = row_of(direction.elevation_rad) * kColumns + column_of(direction.azimuth_rad);
    bins.push_back(static_cast<std::uint32_t>(bin));
    ++begin_[bins.back() + 1];
  }
  for (std::size_t bin = 1; bin < begin_.size(); ++bin) begin_[bin] += begin_[bin - 1];
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const double range_m = points_lidar_m[i].norm();
    rays_[next[bins[i]]++] = {points_lidar_m[i] / range_m, range_m};
  }
}

bool ScanRays::pass_through(const RayQuery& query) const {
  const double distance_m = query.at_m.norm();
  const auto goes_through = [&](const Ray& ray) {
    const double along_m = query.at_m.dot(ray.direction);
    if (along_m <= 0.0 || ray.range_m < along_m + kEndMargin_m) return false;
    const Eigen::Vector3d beside_m = query.at_m - along_m * ray.direction;
    if (beside_m.squaredNorm() > query.touch_m * query.touch_m) return false;
    if (ray.range_m * query.up.dot(ray.direction) < query.lowest_end_m) return false;
    return query.least_below_m <= 0.0 || query.up.dot(beside_m) >= query.least_below_m;
  };
  if (distance_m <= query.touch_m) return std::ranges::any_of(rays_, goes_through);
  const double cone_rad = portable_asin(query.touch_m / distance_m);
  const Direction middle = direction_of(query.at_m);
  const ColumnRange columns = columns_around(middle, query.at_m.head<2>().norm(), query.touch_m);
  const int last_row = row_of(middle.elevation_rad + cone_rad);
  for (int row = row_of(middle.elevation_rad - cone_rad); row <= last_row; ++row) {
    for (int step = 0; step < columns.count; ++step) {
      const int column = (columns.first + step + kColumns) % kColumns;
      const std::size_t bin =
          static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column);
      for (std::uint32_t i = begin_[bin]; i < begin_[bin + 1]; ++i) {
        if (goes_through(rays_[i])) return true;
      }
    }
  }
  return false;
}

}  // namespace sightline

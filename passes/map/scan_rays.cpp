#include "passes/map/scan_rays.h"

#include <algorithm>
#include <cmath>

// Rays lie in bins of direction. A query asks the bins that its cone touches: a handful, where
// walking every ray through space asks every voxel on the way. Bins are bounded by numbers that
// need no trigonometric function: rows by the sine of the elevation, columns by a turn that grows
// with the azimuth, from 0 to 4, by half a unit to one a radian.
//
// Most queries meet no ray at all: they look between two beams. Bands of elevation, far narrower
// than rows, tell so at once.

namespace sightline {
namespace {

constexpr int kColumns = 1024;
constexpr int kRows = 160;
constexpr int kBands = 2000;
constexpr double kColumn = 4.0 / kColumns;
constexpr double kRow = 2.0 / kRows;
// So that rounding moves no ray out of a cone that it touches.
constexpr double kSlack = 1e-9;

double turn_of(const Eigen::Vector3d& p) {
  const double sum = std::abs(p.x()) + std::abs(p.y());
  if (sum == 0.0) return 0.0;
  if (p.y() >= 0.0) return p.x() >= 0.0 ? p.y() / sum : 1.0 - p.x() / sum;
  return p.x() < 0.0 ? 2.0 - p.y() / sum : 3.0 + p.x() / sum;
}

// A float that is no less: rounding takes away less than is added.
float at_least(double range_m) { return static_cast<float>(range_m * (1.0 + 0x1.0p-22)); }

int row_of(double sine) { return std::clamp(static_cast<int>((sine + 1.0) / kRow), 0, kRows - 1); }

std::size_t band_of(double sine) {
  const int band = static_cast<int>((sine + 1.0) * (0.5 * kBands));
  return static_cast<std::size_t>(std::clamp(band, 0, kBands - 1));
}

struct BinRange {
  int first = 0;  // of columns it may be below 0: azimuth goes round
  int count = 0;
};

// A cone of half angle c at elevation e reaches asin(sin c / cos e) to either side. For directions
// that pass a point within touch_m both are lengths over its distance: touch_m, and how far it is
// from the vertical axis.
BinRange columns_around(const Eigen::Vector3d& at_m, double from_axis_m, double touch_m) {
  if (!(touch_m < from_axis_m)) return {0, kColumns};
  const double sine = touch_m / from_axis_m;
  // No less than asin(sine): the terms of its series behind the first sum up to this at sine = 1.
  const double side = sine + 0.5708 * sine * sine * sine + kSlack;
  const double middle = turn_of(at_m);
  const int first = static_cast<int>(std::floor((middle - side) / kColumn));
  const int last = static_cast<int>(std::floor((middle + side) / kColumn));
  return {first, std::min(last - first + 1, kColumns)};
}

// sin(e - c) to sin(e + c); to the pole where the cone holds it.
BinRange rows_around(const Eigen::Vector3d& at_m, double distance_m, double from_axis_m,
                     double touch_m) {
  const double sin_c = touch_m / distance_m;
  const double cos_c = std::sqrt(1.0 - sin_c * sin_c);
  const double middle = at_m.z() / distance_m * cos_c;
  const double side = from_axis_m / distance_m * sin_c + kSlack;
  const bool holds_pole = touch_m >= from_axis_m;
  const int first = row_of(holds_pole && at_m.z() < 0.0 ? -1.0 : middle - side);
  const int last = row_of(holds_pole && at_m.z() > 0.0 ? 1.0 : middle + side);
  return {first, last - first + 1};
}

}  // namespace

void ScanRays::take(std::span<const Eigen::Vector3d> points_lidar_m) {
  rays_.resize(points_lidar_m.size());
  begin_.assign(kRows * kColumns + 2, 0);
  longest_m_.assign(kRows * kColumns, 0.0F);
  longest_of_row_m_.assign(kRows, 0.0F);
  next_band_.assign(kBands + 1, kBands);
  bins_.clear();
  for (const Eigen::Vector3d& point_m : points_lidar_m) {
    const double range_m = point_m.norm();
    const int column = std::min(static_cast<int>(turn_of(point_m) / kColumn), kColumns - 1);
    const double sine = range_m > 0.0 ? point_m.z() / range_m : 0.0;
    const int row = row_of(sine);
    next_band_[band_of(sine)] = static_cast<std::uint16_t>(band_of(sine));
    bins_.push_back(static_cast<std::uint32_t>(row * kColumns + column));
    ++begin_[bins_.back() + 2];
    const float no_less_m = at_least(range_m);
    float& longest_m = longest_m_[bins_.back()];
    longest_m = std::max(longest_m, no_less_m);
    float& of_row_m = longest_of_row_m_[static_cast<std::size_t>(row)];
    of_row_m = std::max(of_row_m, no_less_m);
  }
  for (std::size_t band = kBands; band-- > 0;) {
    if (next_band_[band] != band) next_band_[band] = next_band_[band + 1];
  }
  // A bin's begin stands one further on until its rays have moved it there.
  for (std::size_t bin = 1; bin < begin_.size(); ++bin) begin_[bin] += begin_[bin - 1];
  for (std::size_t i = 0; i < bins_.size(); ++i) {
    const double range_m = points_lidar_m[i].norm();
    rays_[begin_[bins_[i] + 1]++] = {points_lidar_m[i] / range_m, range_m};
  }
}

// Directions at most c apart differ in the sines of their elevations by no more than 2 sin(c / 2),
// which is below 1.04 sin c where sin c is below a half.
bool ScanRays::may_pass(const RayQuery& query, double distance_m) const {
  const double sin_c = query.touch_m / distance_m;
  if (!(sin_c < 0.5)) return true;
  const double sine = query.at_m.z() / distance_m;
  const double side = 1.04 * sin_c + kSlack;
  return next_band_[band_of(sine - side)] <= band_of(sine + side);
}

bool ScanRays::any_in_bin(std::size_t bin, const RayQuery& query) const {
  for (std::uint32_t i = begin_[bin]; i < begin_[bin + 1]; ++i) {
    const Ray& ray = rays_[i];
    const double along_m = query.at_m.dot(ray.direction);
    if (!(along_m > 0.0) || ray.range_m < along_m + kEndMargin_m) continue;
    const Eigen::Vector3d beside_m = query.at_m - along_m * ray.direction;
    if (beside_m.squaredNorm() > query.touch_m * query.touch_m) continue;
    if (ray.range_m * query.up.dot(ray.direction) < query.lowest_end_m) continue;
    if (query.least_below_m <= 0.0 || query.up.dot(beside_m) >= query.least_below_m) return true;
  }
  return false;
}

bool ScanRays::pass_through(const RayQuery& query) const {
  const double distance_m = query.at_m.norm();
  if (distance_m <= query.touch_m) {
    for (std::size_t bin = 0; bin < longest_m_.size(); ++bin) {
      if (any_in_bin(bin, query)) return true;
    }
    return false;
  }
  if (!may_pass(query, distance_m)) return false;
  const double from_axis_m = query.at_m.head<2>().norm();
  const BinRange rows = rows_around(query.at_m, distance_m, from_axis_m, query.touch_m);
  // A ray that passes within touch_m is this far along when it does, or farther.
  const double along_m =
      std::sqrt(distance_m * distance_m - query.touch_m * query.touch_m) * (1.0 - kSlack);
  const auto is_long = [&](int row) {
    return longest_of_row_m_[static_cast<std::size_t>(row)] >= along_m + kEndMargin_m;
  };
  int first_row = rows.first;
  const int end_row = rows.first + rows.count;
  while (first_row < end_row && !is_long(first_row)) ++first_row;
  if (first_row == end_row) return false;
  const BinRange columns = columns_around(query.at_m, from_axis_m, query.touch_m);
  for (int row = first_row; row < end_row; ++row) {
    if (!is_long(row)) continue;
    for (int step = 0; step < columns.count; ++step) {
      const int column = (columns.first + step + kColumns) % kColumns;
      const std::size_t bin =
          static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column);
      if (longest_m_[bin] < along_m + kEndMargin_m) continue;
      if (any_in_bin(bin, query)) return true;
    }
  }
  return false;
}

}  // namespace sightline

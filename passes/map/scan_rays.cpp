#include "passes/map/scan_rays.h"

#include <algorithm>
#include <cmath>

// Rays lie in bins of direction. A query asks the bins that its cone touches: a handful, where
// walking every ray through space asks every voxel on the way. Bins are bounded by numbers that
// need no trigonometric function: rows by the sine of the elevation, columns by a turn that grows
// with the azimuth, from 0 to 4, by half a unit to one a radian.
//
// Most queries meet no ray: they look between two beams, which bands of elevation, far narrower
// than rows, show at once, or at what the rays hit and behind it, which the longest ray of the bins
// around shows. find_passable() checks both for many places in float, with more room than float
// loses, so that it denies no place that the exact test, in double, would not.

namespace sightline {
namespace {

constexpr int kColumns = 1024;
constexpr int kRows = 160;
constexpr int kBands = 2000;
constexpr double kColumn = 4.0 / kColumns;
constexpr double kRow = 2.0 / kRows;
// So that rounding moves no ray out of a cone that it touches.
constexpr double kSlack = 1e-9;
// The same for floats: of a sine or a turn, and of lengths as a share of the longest one that they
// are computed from. Either is ten times what a handful of roundings, of 2^-24 each, come to.
constexpr float kSlackOfFloats = 2e-6F;
constexpr float kLengthSlackOfFloats = 4e-6F;
constexpr std::int16_t kNoPlace = -1;

double turn_of(const Eigen::Vector3d& p) {
  const double sum = std::abs(p.x()) + std::abs(p.y());
  if (sum == 0.0) return 0.0;
  if (p.y() >= 0.0) return p.x() >= 0.0 ? p.y() / sum : 1.0 - p.x() / sum;
  return p.x() < 0.0 ? 2.0 - p.y() / sum : 3.0 + p.x() / sum;
}

// A float that is no less.
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

// Places as floats, so many at once.
constexpr int kAtOnce = 8;
using Floats = Eigen::Array<float, kAtOnce, 1>;
using Whole = Eigen::Array<int, kAtOnce, 1>;
// More than sines differ by.
constexpr float kWholeSphere = 4.0F;

Floats some_of(std::span<const float> all, std::size_t first) {
  if (first + kAtOnce <= all.size()) return Eigen::Map<const Floats>(&all[first]);
  Floats last = Floats::Zero();
  std::copy(all.begin() + static_cast<std::ptrdiff_t>(first), all.end(), last.data());
  return last;
}

Whole bands_of(const Floats& sine) {
  const Floats band = (sine + 1.0F) * (0.5F * kBands);
  return band.max(0.0F).min(kBands - 1.0F).cast<int>();
}

// In the sensor's frame. Sines of elevations as in ScanRays::may_pass().
struct SeenPlaces {
  Floats x_m, y_m, from_axis_m2, distance_m, sine, sin_c, side;
  float touch_m;
  Whole low_band, high_band;

  SeenPlaces(const Floats& x, const Floats& y, const Floats& z, float touch)
      : x_m(x),
        y_m(y),
        from_axis_m2(x * x + y * y),
        distance_m((from_axis_m2 + z * z).sqrt().max(1e-3F)),
        sine(z / distance_m),
        sin_c(touch / distance_m),
        side((sin_c < 0.5F).select(1.04F * sin_c + kSlackOfFloats, kWholeSphere)),
        touch_m(touch),
        low_band(bands_of(sine - side)),
        high_band(bands_of(sine + side)) {}
};

// Azimuths as in columns_around(). A ray that passes goes on for so much beyond the place.
RaySector sector_of(const SeenPlaces& seen, Eigen::Index lane, float beyond_m) {
  const float sin_c = seen.sin_c[lane];
  RaySector sector;
  sector.low_sine = seen.sine[lane] - seen.side[lane];
  sector.high_sine = seen.sine[lane] + seen.side[lane];
  sector.least_range_m =
      seen.distance_m[lane] * std::sqrt(1.0F - sin_c * sin_c) * (1.0F - kSlackOfFloats) + beyond_m;
  const float sine = seen.touch_m / std::sqrt(seen.from_axis_m2[lane]);
  if (!(sine < 0.5F)) return sector;
  const float across = seen.x_m[lane] / (std::abs(seen.x_m[lane]) + std::abs(seen.y_m[lane]));
  sector.turn = seen.y_m[lane] >= 0.0F ? 1.0F - across : 3.0F + across;
  sector.side = sine + 0.5708F * sine * sine * sine + kSlackOfFloats;
  return sector;
}

}  // namespace

void ScanRays::take(std::span<const Eigen::Vector3d> points_lidar_m) {
  find_bins(points_lidar_m);
  begin_.assign(longest_m_.size() + 2, 0);
  for (const std::uint32_t bin : bins_) ++begin_[bin + 2];
  // A bin's begin stands one further on until its rays have moved it there.
  for (std::size_t bin = 1; bin < begin_.size(); ++bin) begin_[bin] += begin_[bin - 1];
  rays_.resize(points_lidar_m.size());
  for (std::size_t i = 0; i < bins_.size(); ++i) {
    const double range_m = ranges_m_[i];
    rays_[begin_[bins_[i] + 1]++] = {points_lidar_m[i] / range_m, range_m};
  }
  find_longest_around();
}

// Of the returns, and which rows and bands they lie in; and the longest of each row and bin.
void ScanRays::find_bins(std::span<const Eigen::Vector3d> points_lidar_m) {
  longest_of_row_m_.assign(kRows, 0.0F);
  next_band_.assign(kBands + 1, kBands);
  bins_.resize(points_lidar_m.size());
  ranges_m_.resize(points_lidar_m.size());
  for (std::size_t i = 0; i < points_lidar_m.size(); ++i) {
    const Eigen::Vector3d& point_m = points_lidar_m[i];
    const double range_m = point_m.norm();
    const int column = std::min(static_cast<int>(turn_of(point_m) / kColumn), kColumns - 1);
    const double sine = range_m > 0.0 ? point_m.z() / range_m : 0.0;
    const int row = row_of(sine);
    next_band_[band_of(sine)] = static_cast<std::uint16_t>(band_of(sine));
    bins_[i] = static_cast<std::uint32_t>(row * kColumns + column);
    ranges_m_[i] = range_m;
    float& of_row_m = longest_of_row_m_[static_cast<std::size_t>(row)];
    of_row_m = std::max(of_row_m, at_least(range_m));
  }
  for (std::size_t band = kBands; band-- > 0;) {
    if (next_band_[band] != band) next_band_[band] = next_band_[band + 1];
  }
  place_of_row_.assign(kRows, kNoPlace);
  std::int16_t places = 0;
  for (std::size_t row = 0; row < kRows; ++row) {
    if (longest_of_row_m_[row] > 0.0F) place_of_row_[row] = places++;
  }
  longest_m_.assign(static_cast<std::size_t>(places) * kColumns, 0.0F);
  for (std::size_t i = 0; i < bins_.size(); ++i) {
    const std::uint32_t row = bins_[i] / kColumns;
    bins_[i] -= (row - static_cast<std::uint32_t>(place_of_row_[row])) * kColumns;
    longest_m_[bins_[i]] = std::max(longest_m_[bins_[i]], at_least(ranges_m_[i]));
  }
}

void ScanRays::find_longest_around() {
  const std::vector<float>* narrower_m = &longest_m_;
  for (std::size_t level = 0; level < longest_around_m_.size(); ++level) {
    std::vector<float>& wider_m = longest_around_m_[level];
    wider_m.resize(longest_m_.size());
    const std::size_t step = std::size_t{1} << level;
    for (std::size_t first = 0; first < wider_m.size(); first += kColumns) {
      const float* from_m = narrower_m->data() + first;
      float* to_m = wider_m.data() + first;
      const auto widen = [&](std::size_t column, std::size_t before, std::size_t after) {
        to_m[column] = std::max(from_m[column], std::max(from_m[before], from_m[after]));
      };
      for (std::size_t c = 0; c < step; ++c) widen(c, c + kColumns - step, c + step);
      for (std::size_t c = step; c < kColumns - step; ++c) widen(c, c - step, c + step);
      for (std::size_t c = kColumns - step; c < kColumns; ++c) {
        widen(c, c - step, c + step - kColumns);
      }
    }
    narrower_m = &wider_m;
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

// Whether some ray of the bins that a sector touches, or of those beside, is long enough.
bool ScanRays::may_hold_longer(const RaySector& sector) const {
  constexpr float kPerColumn = static_cast<float>(1.0 / kColumn);
  constexpr float kPerRow = static_cast<float>(1.0 / kRow);
  const float side = sector.side * kPerColumn;
  if (!(side < 7.0F)) return true;
  const std::size_t level = side < 1.0F ? 0 : side < 3.0F ? 1 : 2;
  const std::size_t column =
      static_cast<std::size_t>(sector.turn * kPerColumn) & std::size_t{kColumns - 1};
  const int last_row = std::min(static_cast<int>((sector.high_sine + 1.0F) * kPerRow), kRows - 1);
  int row = std::max(static_cast<int>((sector.low_sine + 1.0F) * kPerRow), 0);
  for (; row <= last_row; ++row) {
    const std::int16_t place = place_of_row_[static_cast<std::size_t>(row)];
    if (place == kNoPlace) continue;
    const std::size_t bin = static_cast<std::size_t>(place) * kColumns + column;
    if (longest_around_m_[level][bin] >= sector.least_range_m) return true;
  }
  return false;
}

// Floats are off by less than `slack_m`: a ray within touch_m of a place is within `touch` of them.
void ScanRays::find_passable(const RayPlaces& places, const Pose& T_lidar_places, double touch_m,
                             std::vector<std::uint32_t>& found) const {
  const Eigen::Matrix3f turn = T_lidar_places.linear().cast<float>();
  const Eigen::Vector3f anchor_m = (T_lidar_places * places.anchor_m).cast<float>();
  const float slack_m = kLengthSlackOfFloats * (anchor_m.norm() + places.radius_m);
  const float touch = static_cast<float>(touch_m) * (1.0F + kSlackOfFloats) + slack_m;
  const float beyond_m = static_cast<float>(kEndMargin_m) * (1.0F - kSlackOfFloats) - slack_m;
  const std::size_t count = places.x_m.size();
  found.resize(count);
  std::size_t kept = 0;
  for (std::size_t first = 0; first < count; first += kAtOnce) {
    const Floats x = some_of(places.x_m, first);
    const Floats y = some_of(places.y_m, first);
    const Floats z = some_of(places.z_m, first);
    const SeenPlaces seen(turn(0, 0) * x + turn(0, 1) * y + turn(0, 2) * z + anchor_m.x(),
                          turn(1, 0) * x + turn(1, 1) * y + turn(1, 2) * z + anchor_m.y(),
                          turn(2, 0) * x + turn(2, 1) * y + turn(2, 2) * z + anchor_m.z(), touch);
    const std::size_t end = std::min<std::size_t>(kAtOnce, count - first);
    for (std::size_t i = 0; i < end; ++i) {
      const auto lane = static_cast<Eigen::Index>(i);
      if (next_band_[static_cast<std::size_t>(seen.low_band[lane])] > seen.high_band[lane])
        continue;
      found[kept] = static_cast<std::uint32_t>(first + i);
      const bool is_near = seen.side[lane] >= kWholeSphere;
      kept += is_near || may_hold_longer(sector_of(seen, lane, beyond_m)) ? 1 : 0;
    }
  }
  found.resize(kept);
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
    const std::size_t first_bin =
        static_cast<std::size_t>(place_of_row_[static_cast<std::size_t>(row)]) * kColumns;
    for (int step = 0; step < columns.count; ++step) {
      const int column = (columns.first + step + kColumns) % kColumns;
      const std::size_t bin = first_bin + static_cast<std::size_t>(column);
      if (longest_m_[bin] < along_m + kEndMargin_m) continue;
      if (any_in_bin(bin, query)) return true;
    }
  }
  return false;
}

}  // namespace sightline

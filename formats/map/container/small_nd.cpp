#include "formats/map/container/small_nd.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "formats/reader/map_layout.h"

namespace sightline {
namespace {

using Order = std::array<int, 3>;
constexpr std::array<Order, 6> kOrders = {
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
constexpr int kTop = 127;  // of slopes

// A diagonal is never below a thousandth of the first: matching raises smaller ones anyway.
constexpr int kLeastBelowFirst = 40;
constexpr int kLeastScale = -88;  // 2^-22 m^2: half a millimetre

// 2^(i/4), and the geometric middle to the next.
constexpr std::array<double, 4> kQuarters = {1.0, 1.189207115002721, 1.4142135623730951,
                                             1.681792830507429};
constexpr std::array<double, 4> kMiddles = {1.0905077326652577, 1.2968395546510096,
                                            1.5422108254079407, 1.8340080864093424};

double value_of_scale(int scale) {
  return std::ldexp(kQuarters[static_cast<std::size_t>(scale & 3)], scale >> 2);
}

int nearest_scale(double value) {
  if (!(value > value_of_scale(kLeastScale))) return kLeastScale;
  int exponent = 0;
  const double mantissa = 2.0 * std::frexp(value, &exponent);  // in [1, 2)
  const auto above = std::ranges::count_if(kMiddles, [&](double m) { return mantissa >= m; });
  return std::min(4 * (exponent - 1) + static_cast<int>(above), kTop);
}

// 0 to 7 are themselves, then four to an octave.
constexpr std::uint8_t kMostCount = 4 * 30 + 3;
std::uint32_t value_of_count(std::uint8_t code) {
  code = std::min(code, kMostCount);
  if (code < 8) return code;
  return (4U + (code & 3U)) << (code / 4 - 1);
}

std::uint8_t nearest_count(std::uint32_t count) {
  if (count < 8) return static_cast<std::uint8_t>(count);
  const int shift = static_cast<int>(std::bit_width(count)) - 3;
  const std::uint64_t rounded = (std::uint64_t{count} + (std::uint64_t{1} << (shift - 1))) >> shift;
  const int code = 4 * (shift + 1) + static_cast<int>(rounded) - 4;
  return static_cast<std::uint8_t>(std::min<int>(code, kMostCount));
}

std::size_t entry(int row, int column) {
  static constexpr std::array<std::array<std::size_t, 3>, 3> kEntry = {
      {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}}};
  return kEntry[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
}

double at(const NdRow& nd, int row, int column) {
  return static_cast<double>(nd.covariance_m2[entry(row, column)]);
}

std::int8_t nearest_slope(double slope) {
  if (!(std::abs(slope) <= 1.0)) slope = slope > 0.0 ? 1.0 : -1.0;
  return static_cast<std::int8_t>(std::lround(slope * kTop));
}

// By the entries of the covariance in this order of its axes.
void set_covariance(const NdRow& row, std::uint8_t order_number, SmallNd& small) {
  const Order& order = kOrders[order_number];
  const double d0 = std::max(at(row, order[0], order[0]), value_of_scale(kLeastScale));
  const double l10 = at(row, order[1], order[0]) / d0;
  const double l20 = at(row, order[2], order[0]) / d0;
  const int scale0 = nearest_scale(d0);
  const int least = std::max(scale0 - kLeastBelowFirst, kLeastScale);
  const auto below = [&](double value) {
    return static_cast<std::int8_t>(std::clamp(nearest_scale(value), least, kTop));
  };
  small.order = order_number;
  small.scale[0] = static_cast<std::int8_t>(scale0);
  const double d1 =
      std::max(at(row, order[1], order[1]) - l10 * l10 * d0, value_of_scale(kLeastScale));
  small.scale[1] = below(d1);
  const double l21 = (at(row, order[2], order[1]) - l20 * l10 * d0) / d1;
  small.scale[2] = below(at(row, order[2], order[2]) - l20 * l20 * d0 - l21 * l21 * d1);
  small.slope = {nearest_slope(l10), nearest_slope(l20), nearest_slope(l21)};
}

// The axis of the greatest variance first, then that of the greater rest.
std::uint8_t pivot_order(const NdRow& row) {
  int first = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (at(row, axis, axis) > at(row, first, first)) first = axis;
  }
  const int a = first == 0 ? 1 : 0;
  const int b = 3 - first - a;
  const double d0 = std::max(at(row, first, first), value_of_scale(kLeastScale));
  const auto rest = [&](int axis) {
    return at(row, axis, axis) - at(row, axis, first) * at(row, axis, first) / d0;
  };
  const Order order = rest(b) > rest(a) ? Order{first, b, a} : Order{first, a, b};
  return static_cast<std::uint8_t>(std::ranges::find(kOrders, order) - kOrders.begin());
}

double mean_m(std::int32_t units, std::int32_t key, double cell_m) {
  return cell_centre_m(key, cell_m) + static_cast<double>(units) * kMeanUnit_m;
}

// The nearest whole number of units that keeps the mean inside its cell.
std::int32_t mean_units(double mean, std::int32_t key, double cell_m) {
  auto units =
      static_cast<std::int32_t>(std::lround((mean - cell_centre_m(key, cell_m)) / kMeanUnit_m));
  while (floor_to_int(mean_m(units, key, cell_m) / cell_m) != key) units -= units > 0 ? 1 : -1;
  return units;
}

void set_mean(const NdRow& row, std::int32_t half_step, SmallNd& small) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t steps =
        (std::int64_t{row.mean_units[axis]} + 256 * std::int64_t{half_step}) / (2 * half_step);
    small.mean[axis] = static_cast<std::uint8_t>(std::clamp<std::int64_t>(steps, 0, 255));
  }
}

}  // namespace

NdRow row_of(const Nd& nd, double cell_m) {
  const std::array<std::int32_t, 3> key = {nd.key.x, nd.key.y, nd.key.z};
  NdRow row;
  row.point_count = nd.point_count;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    row.mean_units[axis] = mean_units(nd.mean_m[static_cast<int>(axis)], key[axis], cell_m);
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      row.covariance_m2[entry(i, j)] = static_cast<float>(nd.covariance_m2(i, j));
    }
  }
  return row;
}

Nd nd_of(const NdRow& row, const CellKey& key, double cell_m) {
  const std::array<std::int32_t, 3> keys = {key.x, key.y, key.z};
  Nd nd;
  nd.key = key;
  nd.point_count = row.point_count;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    nd.mean_m[static_cast<int>(axis)] = mean_m(row.mean_units[axis], keys[axis], cell_m);
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) nd.covariance_m2(i, j) = at(row, i, j);
  }
  return nd;
}

std::int32_t half_step_units(double cell_m) {
  const double units = std::floor(cell_m / (512.0 * kMeanUnit_m));
  return static_cast<std::int32_t>(std::clamp(units, 1.0, 0x1.0p21));
}

NdRow expanded(const SmallNd& small, std::int32_t half_step) {
  NdRow row;
  row.point_count = value_of_count(small.count);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    row.mean_units[axis] = (2 * std::int32_t{small.mean[axis]} - 255) * half_step;
  }
  const Order& order = kOrders[std::min<std::size_t>(small.order, kOrders.size() - 1)];
  const double d0 = value_of_scale(small.scale[0]);
  const double d1 = value_of_scale(small.scale[1]);
  const double d2 = value_of_scale(small.scale[2]);
  const double l10 = small.slope[0] / static_cast<double>(kTop);
  const double l20 = small.slope[1] / static_cast<double>(kTop);
  const double l21 = small.slope[2] / static_cast<double>(kTop);
  const auto set = [&](std::size_t a, std::size_t b, double value) {
    row.covariance_m2[entry(order[a], order[b])] = static_cast<float>(value);
  };
  set(0, 0, d0);
  set(1, 0, l10 * d0);
  set(2, 0, l20 * d0);
  set(1, 1, l10 * l10 * d0 + d1);
  set(2, 1, l20 * l10 * d0 + l21 * d1);
  set(2, 2, l20 * l20 * d0 + l21 * l21 * d1 + d2);
  return row;
}

SmallNd nearest_small(const NdRow& row, std::int32_t half_step) {
  SmallNd small;
  small.count = std::max<std::uint8_t>(nearest_count(row.point_count), 2);
  set_mean(row, half_step, small);
  set_covariance(row, pivot_order(row), small);
  return small;
}

Nd rounded_small(const Nd& nd, double cell_m) {
  const std::int32_t half_step = half_step_units(cell_m);
  const SmallNd small = nearest_small(row_of(nd, cell_m), half_step);
  return nd_of(expanded(small, half_step), nd.key, cell_m);
}

std::optional<SmallNd> small_of(const NdRow& row, std::int32_t half_step) {
  SmallNd small = nearest_small(row, half_step);
  if (expanded(small, half_step) == row) return small;
  for (std::uint8_t order = 0; order < kOrders.size(); ++order) {
    set_covariance(row, order, small);
    if (expanded(small, half_step) == row) return small;
  }
  return std::nullopt;
}

}  // namespace sightline

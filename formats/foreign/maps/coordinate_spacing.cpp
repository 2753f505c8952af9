#include "formats/foreign/maps/coordinate_spacing.h"

#include <algorithm>
#include <cmath>

#include "formats/base/portable_math.h"

namespace sightline {
namespace {

CoordinateSpacing spacing_along(const std::vector<Eigen::Vector3d>& points_m, int axis) {
  constexpr std::size_t kFewestPoints = 1000;
  constexpr std::size_t kMostPoints = 100'000;
  constexpr double kLeastExtent_m = 10.0;
  constexpr double kFar_m = 1e5;
  if (points_m.size() < kFewestPoints) return {};
  std::vector<double> values_m;
  const std::size_t step = points_m.size() / kMostPoints + 1;
  for (std::size_t i = 0; i < points_m.size(); i += step) values_m.push_back(points_m[i][axis]);
  std::ranges::sort(values_m);
  values_m.erase(std::unique(values_m.begin(), values_m.end()), values_m.end());
  const double largest_m = std::max(std::abs(values_m.front()), std::abs(values_m.back()));
  if (values_m.back() - values_m.front() < kLeastExtent_m || largest_m < kFar_m) return {};
  std::vector<double> steps_m;
  for (std::size_t i = 1; i < values_m.size(); ++i) {
    steps_m.push_back(values_m[i] - values_m[i - 1]);
  }
  const auto low = steps_m.begin() + static_cast<std::ptrdiff_t>(steps_m.size() / 100);
  std::ranges::nth_element(steps_m, low);
  return {*low, largest_m};
}

}  // namespace

bool CoordinateSpacing::is_of_numbers() const {
  constexpr double kRounding = 1e-3;
  constexpr double kLeastOfText_m = 0.9;  // points may well be on a grid of 10 cm
  if (spacing_m <= 0.0) return false;
  const auto largest = static_cast<float>(largest_m);
  const double float_step_m = std::nextafter(largest, 2.0F * largest) - largest;
  constexpr double kLogOfTen = 2.302585092994046;
  const double digits = portable_log(spacing_m) / kLogOfTen;
  return std::abs(spacing_m / float_step_m - 1.0) < kRounding ||
         (spacing_m > kLeastOfText_m && std::abs(digits - std::round(digits)) < kRounding);
}

CoordinateSpacing coordinate_spacing(const std::vector<Eigen::Vector3d>& points_m) {
  const CoordinateSpacing of_x = spacing_along(points_m, 0);
  const CoordinateSpacing of_y = spacing_along(points_m, 1);
  return of_x.spacing_m > of_y.spacing_m ? of_x : of_y;
}

}  // namespace sightline

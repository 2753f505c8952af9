#include "formats/annotation/direction_errors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "formats/base/check.h"

namespace sightline {
namespace {

struct Axis {
  double InitialOffset::*start;
  float AxisErrors::*end;
};
constexpr Axis kAxes[] = {{&InitialOffset::x_m, &AxisErrors::longitudinal_m},
                          {&InitialOffset::y_m, &AxisErrors::lateral_m},
                          {&InitialOffset::z_m, &AxisErrors::height_m},
                          {&InitialOffset::yaw_rad, &AxisErrors::yaw_rad}};

}  // namespace

DirectionErrors direction_errors(std::span<const InitialOffset> starts,
                                 std::span<const AxisErrors> ends) {
  SIGHTLINE_CHECK(starts.size() == ends.size());
  DirectionErrors errors;
  if (starts.empty()) return errors;
  const auto count = static_cast<double>(starts.size());
  for (const auto& [start, end] : kAxes) {
    double start_mean = 0.0;
    double end_mean = 0.0;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      start_mean += starts[i].*start / count;
      end_mean += double{ends[i].*end} / count;
    }
    double start_variance = 0.0;
    double end_variance = 0.0;
    double covariance = 0.0;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const double from = starts[i].*start - start_mean;
      const double to = double{ends[i].*end} - end_mean;
      start_variance += from * from / count;
      end_variance += to * to / count;
      covariance += from * to / count;
    }
    // Offsets that differ by rounding alone are one.
    constexpr double kNone = 1e-24;
    errors.mean.*end = static_cast<float>(end_mean);
    errors.deviation.*end = static_cast<float>(std::sqrt(end_variance));
    errors.kept.*end =
        start_variance > kNone ? static_cast<float>(covariance / start_variance) : 0.0F;
  }
  return errors;
}

}  // namespace sightline

#include "formats/foreign/clouds/point_cloud_file.h"

#include <cmath>

#include "formats/base/check.h"

namespace sightline {
namespace {

// No driver writes its unit into the file. A scan takes between 2 ms and 2 s, and the usual units
// are a thousandfold apart, so the span of the times leaves one unit.
constexpr double kShortestScan_ns = 2e6;
constexpr double kLongestScan_ns = 2e9;

std::optional<double> unit_ns(double span, std::optional<double> known_ns) {
  for (const double unit : {1e9, 1e6, 1e3, 1.0}) {
    if (unit != known_ns.value_or(unit)) continue;
    const double span_ns = span * unit;
    if (span_ns > kShortestScan_ns && span_ns <= kLongestScan_ns) return unit;
  }
  return std::nullopt;
}

}  // namespace

void set_point_times(std::span<const double> times, PointCloudFile& cloud,
                     std::optional<double> known_unit_ns) {
  SIGHTLINE_CHECK(times.size() == cloud.points_m.size());
  cloud.time_offset_ns.clear();
  cloud.time_origin_ns.reset();
  if (times.empty()) return;
  const bool are_finite = std::ranges::all_of(times, [](double t) { return std::isfinite(t); });
  const auto [first, last] = std::ranges::minmax(times);
  if (are_finite && first == last) return;  // the stamp of the whole scan, once more
  const std::optional<double> unit =
      are_finite ? unit_ns(last - first, known_unit_ns) : std::nullopt;
  constexpr double kMost_ns = 4e18;  // what an int64 holds
  if (!unit || std::abs(first) * *unit > kMost_ns || std::abs(last) * *unit > kMost_ns) {
    cloud.has_unclear_times = true;
    return;
  }
  const double largest_ns = std::max(std::abs(first), std::abs(last)) * *unit;
  const bool is_relative = largest_ns <= kLongestScan_ns;
  const double origin = is_relative ? 0.0 : first;
  if (!is_relative) cloud.time_origin_ns = std::llround(first * *unit);
  cloud.time_offset_ns.reserve(times.size());
  for (const double time : times) {
    cloud.time_offset_ns.push_back(static_cast<std::int32_t>(std::lround((time - origin) * *unit)));
  }
}

}  // namespace sightline

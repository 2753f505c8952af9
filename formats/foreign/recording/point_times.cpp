#include "formats/foreign/recording/point_times.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "formats/base/units.h"

namespace sightline {
namespace {

constexpr double kSecond = 1e9;

std::int64_t in_two_digits(std::int64_t value) {
  std::int64_t unit = 1;
  while (value / unit >= 100) unit *= 10;
  return (value + unit / 2) / unit * unit;
}

// From 0 to 1, or from -1 to 0, of scans that come faster than once a second.
bool are_shares(std::int64_t first_ns, std::int64_t last_ns, std::int64_t step_ns) {
  constexpr double kLeastSpan = 0.9;
  constexpr double kRounding = 1.001;
  constexpr double kLongerThanStep = 1.5;
  const auto first = static_cast<double>(first_ns) / kSecond;
  const auto last = static_cast<double>(last_ns) / kSecond;
  const auto step = static_cast<double>(step_ns) / kSecond;
  return first >= -kRounding && last <= kRounding && last - first >= kLeastSpan &&
         last - first > kLongerThanStep * step;
}

bool is_too_long(std::int64_t span_ns, std::int64_t step_ns) {
  constexpr double kMostSteps = 2.5;
  return static_cast<double>(span_ns) > kMostSteps * static_cast<double>(step_ns);
}

// Whether times from first to last, ns after the stamp, are of a scan with this stamp.
bool is_of_stamp(std::int64_t first_ns, std::int64_t last_ns, std::int64_t step_ns) {
  constexpr std::int64_t kNear_ns = 2 * kSecond_ns;
  constexpr std::int64_t kUsualSweep_ns = kSecond_ns / 10;
  constexpr std::int64_t kMost_ns = std::numeric_limits<std::int32_t>::max();
  if (last_ns > kMost_ns || first_ns < -kMost_ns) return false;
  if (step_ns == 0) return first_ns >= -kNear_ns && first_ns <= kNear_ns;
  const std::int64_t sweep_ns = std::max(last_ns - first_ns, std::min(step_ns, kUsualSweep_ns));
  return first_ns <= sweep_ns && last_ns >= -sweep_ns;
}

}  // namespace

std::int64_t usual_step_ns(std::span<const RecordedScan> scans) {
  std::vector<std::int64_t> steps_ns;
  for (std::size_t i = 1; i < scans.size(); ++i) {
    steps_ns.push_back(scans[i].stamp_ns - scans[i - 1].stamp_ns);
  }
  if (steps_ns.empty()) return 0;
  const auto middle = steps_ns.begin() + static_cast<std::ptrdiff_t>((steps_ns.size() - 1) / 2);
  std::ranges::nth_element(steps_ns, middle);
  return in_two_digits(std::max<std::int64_t>(*middle, 0));
}

SettledTimes settle_point_times(std::int64_t stamp_ns, std::int64_t step_ns,
                                PointCloudFile& cloud) {
  SettledTimes settled;
  std::vector<std::int32_t>& times_ns = cloud.time_offset_ns;
  if (times_ns.empty()) return settled;
  const auto [first, last] = std::ranges::minmax(times_ns);
  const std::int64_t first_ns = first;
  const std::int64_t last_ns = last;
  settled.span_ns = last_ns - first_ns;
  if (!cloud.time_origin_ns && step_ns > 0 && are_shares(first_ns, last_ns, step_ns)) {
    settled.kind = PointTimesKind::kShares;
    const double scale = static_cast<double>(step_ns) / kSecond;
    for (std::int32_t& time_ns : times_ns) {
      time_ns = static_cast<std::int32_t>(std::lround(static_cast<double>(time_ns) * scale));
    }
    return settled;
  }
  if (step_ns > 0 && is_too_long(settled.span_ns, step_ns)) {
    settled.kind = PointTimesKind::kTooLong;
    times_ns.clear();
    return settled;
  }
  const std::int64_t shift_ns = cloud.time_origin_ns ? *cloud.time_origin_ns - stamp_ns : 0;
  const bool is_same_clock = is_of_stamp(shift_ns + first_ns, shift_ns + last_ns, step_ns);
  if (!is_same_clock) {
    settled.kind = PointTimesKind::kOtherClock;
    settled.ahead_ns = shift_ns + first_ns;
  }
  const auto add_ns = static_cast<std::int32_t>(is_same_clock ? shift_ns : -first_ns);
  for (std::int32_t& time_ns : times_ns) time_ns += add_ns;
  return settled;
}

}  // namespace sightline

#include "formats/foreign/clouds/point_cloud_file.h"

#include <algorithm>
#include <array>
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

constexpr std::string_view kCurvature = "curvature";

std::string in_small_letters(std::string_view text) {
  std::string small(text);
  std::ranges::transform(small, small.begin(), [](unsigned char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : static_cast<char>(c);
  });
  return small;
}

// Ends of names that give a unit.
struct UnitEnding {
  std::string_view text;
  double unit_ns;
};
constexpr std::array<UnitEnding, 5> kUnitEndings = {
    {{"_ns", 1.0}, {"_us", 1e3}, {"_ms", 1e6}, {"_sec", 1e9}, {"_s", 1e9}}};

const UnitEnding* unit_ending_of(std::string_view small) {
  const auto* found = std::ranges::find_if(
      kUnitEndings, [&](const UnitEnding& ending) { return small.ends_with(ending.text); });
  return found == kUnitEndings.end() ? nullptr : found;
}

// Many points, few times: a stamp of the whole scan in a number that holds too few digits, say.
bool are_too_few(std::span<const double> times) {
  constexpr std::size_t kManyPoints = 1000;
  if (times.size() < kManyPoints) return false;
  std::vector<double> different;
  for (const double time : times) {
    if (!different.empty() && time == different.back()) continue;
    if (std::ranges::find(different, time) != different.end()) continue;
    different.push_back(time);
    if (different.size() >= kFewestTimes) return false;
  }
  return true;
}

}  // namespace

bool is_time_name(std::string_view name) {
  constexpr std::array<std::string_view, 13> kNames = {
      "t",           "time",        "timestamp",   "timestamps", "time_stamp",
      "time_stamps", "offset_time", "time_offset", "gps_time",   "gpstime",
      "point_time",  "rel_time",    kCurvature};
  std::string small = in_small_letters(name);
  if (name == "T") return false;  // temperature
  if (const UnitEnding* ending = unit_ending_of(small)) {
    small.resize(small.size() - ending->text.size());
  }
  return std::ranges::find(kNames, small) != kNames.end();
}

bool TimeName::take(std::string_view name) {
  if (is_time_name(name)) {
    if (name == kCurvature && !name_.empty()) return false;
    name_ = name;
    return true;
  }
  const std::string small = in_small_letters(name);
  const bool may_be_time = small.find("time") != std::string::npos ||
                           small.find("stamp") != std::string::npos || small == "ts";
  if (may_be_time && unread_.empty()) unread_ = name;
  return false;
}

std::optional<double> TimeName::unit_ns() const {
  constexpr double kMillisecond_ns = 1e6;
  if (name_ == kCurvature) return kMillisecond_ns;
  const UnitEnding* ending = unit_ending_of(in_small_letters(name_));
  if (ending == nullptr) return std::nullopt;
  return ending->unit_ns;
}

void TimeName::set_times(std::span<const double> times, PointCloudFile& cloud) const {
  if (name_.empty()) {
    cloud.unread_time = unread_;
    return;
  }
  set_point_times(times, cloud, unit_ns());
  if (name_ == kCurvature) cloud.has_unclear_times = false;  // of a surface
}

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
      are_finite && !are_too_few(times) ? unit_ns(last - first, known_unit_ns) : std::nullopt;
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

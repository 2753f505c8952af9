#include "passes/emit/tracking_columns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace sightline {
namespace {

constexpr double kBeside_m = 5.0;  // sites that are pooled, along the run
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Steps of a twelfth of a power of two, 6 %, from the least on; +inf: not measured.
std::vector<float> log_steps(double least, std::size_t count) {
  constexpr double kFactor = 1.0594630943592953;  // 2^(1/12)
  std::vector<float> steps;
  double value = least;
  for (std::size_t i = 0; i < count; ++i, value *= kFactor) {
    steps.push_back(static_cast<float>(value));
  }
  steps.push_back(kInfinity);
  return steps;
}

// 1/64 apart, from -0.5 to 1.5; +inf: not measured.
std::vector<float> even_steps() {
  std::vector<float> steps;
  for (int i = -32; i <= 96; ++i) steps.push_back(static_cast<float>(i) / 64.0F);
  steps.push_back(kInfinity);
  return steps;
}

// The nearest; the lower of two.
float nearest_step(const std::vector<float>& steps, double value) {
  const auto last = steps.end() - 2;  // of the finite ones
  const auto above = std::lower_bound(steps.begin(), last, static_cast<float>(value));
  if (above == steps.begin()) return *above;
  const float below = *(above - 1);
  return value - double{below} <= double{*above} - value ? below : *above;
}

// Sums over the tracking starts of the sites around one.
struct Pooled {
  std::size_t count = 0;
  std::array<double, 3> square{};  // longitudinal, lateral, yaw
  std::size_t site_count = 0;
  double kept = 0.0;
};

void add_site(const MeasuredError& measured, std::size_t site, std::size_t look, Pooled& pooled) {
  const std::span<const AxisErrors> ends = measured.tracking(site, look);
  for (const AxisErrors& end : ends) {
    const std::array<double, 3> axes = {double{end.longitudinal_m}, double{end.lateral_m},
                                        double{end.yaw_rad}};
    for (std::size_t i = 0; i < axes.size(); ++i) pooled.square[i] += axes[i] * axes[i];
  }
  pooled.count += ends.size();
  // The starts are those of every site: the slope of all is the mean of the sites' own.
  pooled.kept += double{direction_errors(measured.tracking_offsets, ends).kept.longitudinal_m};
  ++pooled.site_count;
}

Pooled pooled_around(const MeasuredError& measured, std::size_t site, std::size_t look,
                     const Sites& sites) {
  const Site& here = sites.sites[site];
  const auto is_beside = [&](std::size_t i) {
    return sites.sites[i].run == here.run && std::abs(sites.sites[i].s_m - here.s_m) <= kBeside_m;
  };
  std::size_t first = site;
  while (first > 0 && is_beside(first - 1)) --first;
  Pooled pooled;
  for (std::size_t i = first; i < sites.sites.size() && is_beside(i); ++i) {
    if (measured.scan_of_site[i] >= 0) add_site(measured, i, look, pooled);
  }
  return pooled;
}

}  // namespace

std::optional<std::size_t> tracking_look(const MeasuredError& measured) {
  const std::vector<Look>& looks = measured.looks;
  if (measured.tracking_offsets.empty() || looks.empty()) return std::nullopt;
  if (takes_every_return(looks.back())) return looks.size() - 1;
  constexpr std::uint32_t kPoints = 64;
  const auto found =
      std::ranges::find_if(looks, [](const Look& look) { return look.point_count >= kPoints; });
  return found == looks.end() ? looks.size() - 1 : static_cast<std::size_t>(found - looks.begin());
}

std::vector<SiteColumn> tracking_columns(const MeasuredError& measured, std::size_t look,
                                         const Sites& sites,
                                         std::span<const std::string_view> names) {
  constexpr double kLeast_m = 0.001;
  constexpr double kLeast_rad = 1e-5;
  constexpr std::size_t kLogSteps = 168;  // 14 powers of two: to 15 m and 0.15 rad
  std::vector<SiteColumn> columns;
  const std::array<std::string, 4> units = {"m", "m", "rad", ""};
  const std::array<std::vector<float>, 4> steps = {log_steps(kLeast_m, kLogSteps),
                                                   log_steps(kLeast_m, kLogSteps),
                                                   log_steps(kLeast_rad, kLogSteps), even_steps()};
  for (std::size_t i = 0; i < units.size(); ++i) {
    columns.push_back({std::string(names[i]), units[i],
                       std::vector<float>(sites.sites.size(), kInfinity), steps[i]});
  }
  for (std::size_t site = 0; site < sites.sites.size(); ++site) {
    const Pooled pooled = pooled_around(measured, site, look, sites);
    if (pooled.site_count == 0) continue;
    for (std::size_t i = 0; i < pooled.square.size(); ++i) {
      const double deviation = std::sqrt(pooled.square[i] / static_cast<double>(pooled.count));
      columns[i].values[site] = nearest_step(steps[i], deviation);
    }
    columns[3].values[site] =
        nearest_step(steps[3], pooled.kept / static_cast<double>(pooled.site_count));
  }
  return columns;
}

}  // namespace sightline

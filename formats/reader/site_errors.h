#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

// How far off the matches of a vehicle that tracks are, by direction.

namespace sightline {

// Standard deviations about the true pose, in the vehicle's axes there ("Errors by direction" in
// schemas/definitions.md). Infinite where nothing was measured.
struct PoseErrors {
  double longitudinal_m = std::numeric_limits<double>::infinity();
  double lateral_m = std::numeric_limits<double>::infinity();
  double yaw_rad = std::numeric_limits<double>::infinity();
  // Share of the longitudinal error of the start that the match keeps: 0 where the scan decides, 1
  // where nothing constrains it. A filter must not count that share as a measurement.
  double kept_longitudinal = std::numeric_limits<double>::infinity();
};

// The columns of a map that begin with "tracking_". Refers into the map.
struct MapErrors {
  struct Column {
    std::span<const std::uint8_t> numbers;  // [site], of steps
    std::span<const float> steps;

    [[nodiscard]] double at(std::uint32_t site) const {
      if (site >= numbers.size() || numbers[site] >= steps.size()) {
        return std::numeric_limits<double>::infinity();
      }
      return double{steps[numbers[site]]};
    }
  };
  using Columns = std::array<Column, 4>;  // in the order of PoseErrors

  Columns ranges;   // of the longest range
  Columns samples;  // of a look that takes a sample

  [[nodiscard]] PoseErrors of_range(std::uint32_t site) const { return errors(ranges, site); }
  [[nodiscard]] PoseErrors of_sample(std::uint32_t site) const { return errors(samples, site); }

 private:
  static PoseErrors errors(const Columns& columns, std::uint32_t site) {
    return {columns[0].at(site), columns[1].at(site), columns[2].at(site), columns[3].at(site)};
  }
};

// Names of these columns, in the order of PoseErrors.
inline constexpr std::array<std::string_view, 4> kTrackingRangeColumns = {
    "tracking_longitudinal_m", "tracking_lateral_m", "tracking_yaw_rad",
    "tracking_kept_longitudinal"};
inline constexpr std::array<std::string_view, 4> kTrackingSampleColumns = {
    "tracking_sample_longitudinal_m", "tracking_sample_lateral_m", "tracking_sample_yaw_rad",
    "tracking_sample_kept_longitudinal"};

}  // namespace sightline

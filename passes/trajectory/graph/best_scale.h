#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/geometry.h"

// The scale at which a scan fits a map best, to compare how drives measure distances.

namespace sightline {

// The match of a scan at one scale: the larger `fit`, the better. It is sure where others may be
// judged by it.
struct FitAtScale {
  double fit = 0.0;
  bool is_sure = false;
};
using MatchAtScale = std::function<FitAtScale(const std::vector<Eigen::Vector3d>& scaled_m)>;

// Scales of 0.96 to 1.04 are tried, in steps of 1 %, then of 0.5 % beside the best; between them
// the best one is at the top of the parabola through the logarithms of the fits. None where the
// best is the first or the last, or not sure. `points_m`: in the frame of the sensor.
std::optional<double> best_scale(const std::vector<Eigen::Vector3d>& points_m,
                                 const MatchAtScale& match);

// The ratio of each of `count` scans, in their order; scans without one are left out. Shared by
// `threads`. Error: the first of ratio_of.
Result<std::vector<double>> ratios_of_scans(
    int threads, std::size_t count,
    const std::function<Result<std::optional<double>>(std::size_t)>& ratio_of);

// The common ratio of several scans: their median where it differs from 1 by more than 0.3 %, and
// three quarters of three scans or more differ in that direction by half as much; else 1. Ratios of
// scans of recorded streets and of generated towns are within 0.3 % of 1, their medians within 0.1
// %.
double common_ratio(std::vector<double> ratios);
// Fewer ratios give 1.
inline constexpr std::size_t kLeastRatios = 3;

}  // namespace sightline

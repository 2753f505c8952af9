#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/geometry.h"

// At which scale a scan fits best what others saw; so two drives are compared on how far away
// things are.

namespace sightline {

// What a match of a scan at one scale says; the better, the greater. It is sure where it is a place
// that others may be judged by.
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

// What each of so many scans says, in their order; those that say nothing are left out. Shared by
// `threads`. Error: the first of ratio_of.
Result<std::vector<double>> ratios_of_scans(
    int threads, std::size_t count,
    const std::function<Result<std::optional<double>>(std::size_t)>& ratio_of);

// What the ratios of several scans say together: their median where it is over 0.3 % off 1, and
// three quarters of three scans or more are off that way by half as much; else 1. Scans of recorded
// streets and of generated towns that agree are off by 0.3 % at most, their medians by 0.1 %.
double ratio_told_by(std::vector<double> ratios);
// Fewer ratios say nothing.
inline constexpr std::size_t kLeastRatios = 3;

}  // namespace sightline

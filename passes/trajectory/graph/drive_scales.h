#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/geometry.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// Two parts of a drive that differ.
struct ScaleDifference {
  std::uint32_t earlier = 0;
  std::uint32_t later = 0;
  double ratio = 1.0;  // of the later one's distances to the earlier one's
  std::uint32_t scan_count = 0;
};

// Compares each part of a drive with the three earlier parts that it meets most: four scans of each
// pair, evenly along the common way, are matched to maps of the earlier part at scales of 0.96 to
// 1.04 (best_scale). Pairs whose common_ratio is not 1 are returned. Such a drive is joined all the
// same, and doubles walls; its loops, which match in the middle, do not show it. `from`: earlier
// scans are not judged, but others are compared with them. Shared by ctx.threads. Error: that of
// reading a scan.
Result<std::vector<ScaleDifference>> find_scale_differences(const PassContext& ctx,
                                                            const Drive& drive,
                                                            const Trajectory& trajectory,
                                                            std::size_t from = 0);

std::string to_text(const ScaleDifference& found, const Drive& drive);

// One warning of all differences; none without any. Error: that of finding them.
Result<void> warn_of_scale_differences(const PassContext& ctx, const Drive& drive,
                                       const Trajectory& trajectory, std::size_t from = 0);

// The scale at which a scan fits a map best, to compare how drives measure distances.

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

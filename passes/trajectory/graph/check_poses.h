#pragma once

#include <algorithm>
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
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/graph/pose_graph.h"

// What estimated poses are checked by: loops that contradict them, and drives that measure
// distances otherwise than each other.

namespace sightline {

// A stretch of the later visit whose loops contradict the trajectory.
struct Contradiction {
  std::uint32_t first = 0;  // scans of the later visit
  std::uint32_t last = 0;
  std::uint32_t loop_count = 0;
  std::uint32_t off_count = 0;  // of these loops
  std::uint32_t earlier = 0;    // scans of the worst loop
  std::uint32_t later = 0;
  double off_m = 0.0;
};

// Contradictions by the loops (find_loops) between two pieces of the odometry, or within one, along
// the way of the later scans: where, of six consecutive loops, half and at least three put the
// later scan more than 0.25 m from `T_map_lidar`, five times the error of a loop. Then the
// trajectory is bent, or places that look alike were confused.
std::vector<Contradiction> find_contradictions(const Odometry& odometry,
                                               const std::vector<GraphEdge>& loops,
                                               const std::vector<Pose>& T_map_lidar);

// Poses of a drive, and the loops that contradict them.
struct Estimate {
  Trajectory trajectory;
  std::vector<Contradiction> contradictions = {};
};

std::string to_text(const Contradiction& found, const Drive& drive);

// "what: a; b; c; ...": the first five of the places that were found, by their to_text().
template <class Found>
std::string with_first_places(const std::string& what, const std::vector<Found>& found,
                              const Drive& drive) {
  constexpr std::size_t kMostTold = 5;
  std::string text = what;
  for (std::size_t i = 0; i < std::min(found.size(), kMostTold); ++i) {
    text += (i == 0 ? ": " : "; ") + to_text(found[i], drive);
  }
  if (found.size() > kMostTold) text += "; ...";
  return text;
}

// One warning of all contradictions, which is also added to `notices`; none without any.
void warn_of_contradictions(const PassContext& ctx, const Drive& drive,
                            const std::vector<Contradiction>& found, std::vector<Notice>& notices);

// Two parts of a drive that differ.
struct ScaleDifference {
  std::uint32_t earlier = 0;
  std::uint32_t later = 0;
  double ratio = 1.0;  // of the later one's distances to the earlier one's
  std::uint32_t scan_count = 0;
};

// Compares each part of a drive with the three earlier parts that it meets most, four scans of each
// pair at several scales (best_scale); pairs whose common_ratio is not 1 are returned. Such a drive
// is joined all the same, and doubles walls; its loops, which match in the middle, do not show it.
// `from`: earlier scans are not judged, but others are compared with them. Shared by ctx.threads.
// Error: that of reading a scan.
Result<std::vector<ScaleDifference>> find_scale_differences(const PassContext& ctx,
                                                            const Drive& drive,
                                                            const Trajectory& trajectory,
                                                            std::size_t from = 0);

std::string to_text(const ScaleDifference& found, const Drive& drive);

// One warning of all differences, which is also added to the trajectory's notices; none without
// any. Error: that of finding them.
Result<void> warn_of_scale_differences(const PassContext& ctx, const Drive& drive,
                                       Trajectory& trajectory, std::size_t from = 0);

// The match of a scan with a map at one scale, to compare how drives measure distances: the larger
// `fit`, the better. It is sure where others may be judged by it.
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

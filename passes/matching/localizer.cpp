#include "passes/matching/localizer.h"

#include <algorithm>
#include <array>
#include <utility>

#include "compiler/base/check.h"
#include "passes/matching/coarse_map.h"
#include "passes/matching/scan_preparation.h"

// Why levels: wide NDs have a wide basin and a blunt optimum, sharp ones the reverse. A level that
// only shows the way may end far from its optimum and needs few points; what it costs is small
// beside the last level, which starts so near that it takes three or four evaluations.

namespace sightline {
namespace {

constexpr std::size_t kMostLevels = 3;
constexpr double kBlur_m = 0.2;        // about what starts are off by after the first steps
constexpr double kSharpFloor = 0.003;  // of the largest eigenvalue: 3 cm in a wall of 2 m
constexpr std::size_t kThinStride = 4;
constexpr std::size_t kFewestThin = 64;  // points that still see every wall near

// An ND's eigenvalues below `floor` of the largest raised to it, then all by the blur's square.
InformationOfNd information(double floor, double blur_m) {
  return [floor, blur_m](const Nd& nd) -> Eigen::Matrix3d {
    const Eigen::Vector3d lambda_m2 =
        (nd.eigenvalues_m2.cwiseMax(floor * nd.eigenvalues_m2[0]).array() + blur_m * blur_m)
            .matrix();
    const Eigen::Matrix3d inverse =
        nd.eigenvectors * lambda_m2.cwiseInverse().asDiagonal() * nd.eigenvectors.transpose();
    return 0.5 * (inverse + inverse.transpose());
  };
}

// A level that shows the way to the next: a part of the points, ended early.
MatchLevel leading_level(double stop_step_m) {
  MatchLevel level;
  level.is_thin = true;
  level.stop_step_m = stop_step_m;
  level.stop_step_rad = stop_step_m / 50.0;  // as much at a range of 50 m
  return level;
}

}  // namespace

Localizer make_localizer(const NdtMap& map, const LocalizerOptions& options) {
  SIGHTLINE_CHECK(options.coarse_cells >= 1);
  Localizer localizer;
  localizer.is_annealed = options.is_annealed;
  const bool has_coarse = options.coarse_cells > 1;
  const NdtMap coarse = has_coarse ? coarse_map(map, options.coarse_cells) : NdtMap{};
  const NdtMap& widest = has_coarse ? coarse : map;
  const auto add = [&](MatchGrid grid, const MatchLevel& settings) {
    localizer.levels.push_back({std::move(grid), settings});
  };
  if (!options.is_annealed) {
    if (has_coarse) add(make_match_grid(coarse), MatchLevel{});
    add(make_match_grid(map), MatchLevel{});
    return localizer;
  }
  const InformationOfNd sharp = information(kSharpFloor, 0.0);
  add(make_match_grid(widest, information(0.01, kBlur_m)), leading_level(0.02));
  if (has_coarse) add(make_match_grid(coarse, sharp), leading_level(0.01));
  add(make_match_grid(map, sharp), MatchLevel{});
  return localizer;
}

ScanForMatch make_scan_for_match(const Localizer& localizer,
                                 std::span<const Eigen::Vector3d> points_m) {
  const std::size_t stride =
      localizer.is_annealed ? std::clamp(points_m.size() / kFewestThin, std::size_t{1}, kThinStride)
                            : std::size_t{1};
  return make_scan_for_match(points_m, stride);
}

ScanForMatch make_scan_for_match(const Localizer& localizer, const Scan& scan,
                                 const SensorProfile& sensor, const ScanCut& cut) {
  std::vector<Eigen::Vector3d> points_m =
      voxel_subsample(crop(scan.points_m, cut.range_m), cut.leaf_m);
  for (Eigen::Vector3d& point_m : points_m) point_m = sensor.T_vehicle_lidar * point_m;
  return make_scan_for_match(localizer, points_m);
}

MatchResult localize(const Localizer& localizer, ScanForMatch& scan, const Pose& T_map_start,
                     const MatchOptions& options) {
  const std::size_t count = localizer.levels.size();
  if (count == 1) return match(localizer.levels[0].grid, scan, T_map_start, options);
  SIGHTLINE_CHECK(count > 0 && count <= kMostLevels);
  std::array<MatchLevel, kMostLevels> levels;
  for (std::size_t i = 0; i < count; ++i) {
    levels[i] = localizer.levels[i].settings;
    levels[i].grid = &localizer.levels[i].grid;
  }
  MatchLevel& last = levels[count - 1];
  last.max_step_m = options.max_step_m;
  last.max_step_rad = options.max_step_rad;
  last.stop_step_m = options.stop_step_m;
  last.stop_step_rad = options.stop_step_rad;
  return match(std::span(levels).first(count), scan, T_map_start, options);
}

}  // namespace sightline

#include "passes/factors/virtual/virtual_match.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "formats/base/portable_math.h"
#include "formats/base/random.h"
#include "passes/matching/match_starts.h"

namespace sightline {
namespace {

constexpr double kHidden_rad = 0.5 * std::numbers::pi;  // of azimuth
constexpr double kNoise_m = 0.085;                      // the most, each coordinate
constexpr std::uint64_t kNoiseSeed = 0x7669727475616cULL;

Pose start_of(const VirtualPlace& place, const InitialOffset& offset) {
  Pose T_map_start = start_pose(offset);  // the scan's axes are the map's: turned by the yaw alone
  T_map_start.translation() = place.p_map_m + place.R_map_vehicle * T_map_start.translation();
  return T_map_start;
}

double azimuth_from(double azimuth_rad, const Eigen::Vector3d& point_m) {
  const double difference_rad = portable_atan2(point_m.y(), point_m.x()) - azimuth_rad;
  return std::abs(std::remainder(difference_rad, 2.0 * std::numbers::pi));
}

// What start k of `count` sees: as if something large stood near, another side for every start.
std::vector<Eigen::Vector3d> disturbed(std::span<const Eigen::Vector3d> points_m, std::size_t k,
                                       std::size_t count) {
  const double hidden_rad =
      2.0 * std::numbers::pi * static_cast<double>(5 * k % count) / static_cast<double>(count);
  Random random(mix(kNoiseSeed, k));
  std::vector<Eigen::Vector3d> seen_m;
  seen_m.reserve(points_m.size());
  for (const Eigen::Vector3d& point_m : points_m) {
    Eigen::Vector3d noise_m;
    for (double& coordinate_m : noise_m) coordinate_m = random.uniform(-kNoise_m, kNoise_m);
    if (azimuth_from(hidden_rad, point_m) > 0.5 * kHidden_rad) {
      seen_m.emplace_back(point_m + noise_m);
    }
  }
  return seen_m;
}

double rival_score(const Localizer& localizer, const VirtualPlace& place, ScanForMatch& scan) {
  constexpr double kStep_m = 0.25;
  constexpr int kNearest = 2;  // steps
  constexpr int kFarthest = 10;
  const SinCos heading = portable_sin_cos(place.loose_heading_deg * std::numbers::pi / 180.0);
  const auto score_at = [&](int steps) {
    Pose T_map_scan = Pose::Identity();
    T_map_scan.translation() =
        place.p_map_m + steps * kStep_m * Eigen::Vector3d(heading.cos, heading.sin, 0.0);
    return kernel_score_alone(*localizer.levels.front().grid, scan, scan.points_m.size(),
                              T_map_scan, MatchKernel::kFastest);
  };
  const double here = score_at(0);
  if (!(here > 0.0)) return 1.0;
  double best = 0.0;
  for (int steps = kNearest; steps <= kFarthest; ++steps) {
    best = std::max({best, score_at(steps), score_at(-steps)});
  }
  return best / here;
}

}  // namespace

VirtualMatch virtual_match(const Localizer& localizer, const VirtualPlace& place) {
  const std::vector<InitialOffset> offsets = initial_offsets(StartPattern{});
  VirtualMatch result;
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    ScanForMatch scan =
        make_scan_for_match(localizer, disturbed(place.points_m, k, offsets.size()));
    const Pose T_map_found = localize(localizer, scan, start_of(place, offsets[k])).T_map_sensor;
    result.error_m +=
        (T_map_found.translation() - place.p_map_m).norm() / static_cast<double>(offsets.size());
  }
  ScanForMatch whole = make_scan_for_match(localizer, place.points_m);
  result.rival_score = rival_score(localizer, place, whole);
  return result;
}

}  // namespace sightline

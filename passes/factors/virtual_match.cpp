#include "passes/factors/virtual_match.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "formats/base/portable_math.h"
#include "formats/base/random.h"
#include "passes/matching/match_starts.h"

namespace sightline {
namespace {

constexpr std::size_t kViews = 4;
constexpr double kHidden_rad = 0.5 * std::numbers::pi;  // of azimuth, in each view
constexpr double kNoise_m = 0.085;                      // the most, each coordinate
constexpr std::uint64_t kNoiseSeed = 0x7669727475616cULL;

Pose start_of(const VirtualPlace& place, const InitialOffset& offset) {
  Pose T_map_start = start_pose(offset);  // the scan's axes are the map's: turned by the yaw alone
  T_map_start.translation() = place.p_map_m + place.R_map_vehicle * T_map_start.translation();
  return T_map_start;
}

std::vector<double> azimuths_of(std::span<const Eigen::Vector3d> points_m) {
  std::vector<double> azimuths_rad;
  azimuths_rad.reserve(points_m.size());
  for (const Eigen::Vector3d& point_m : points_m) {
    azimuths_rad.push_back(portable_atan2(point_m.y(), point_m.x()));
  }
  return azimuths_rad;
}

// Between two azimuths less than a turn and a half apart. What is more than half a turn lies
// between a half and twice the whole one, so that this difference is exact: std::remainder's, which
// takes far longer.
double angle_between(double a_rad, double b_rad) {
  const double apart_rad = std::abs(a_rad - b_rad);
  return apart_rad <= std::numbers::pi ? apart_rad : std::abs(2.0 * std::numbers::pi - apart_rad);
}

// What a view shows: as if something large stood near, on another side in each.
void see_disturbed(const VirtualPlace& place, std::span<const double> azimuths_rad,
                   std::size_t view, std::vector<Eigen::Vector3d>& seen_m) {
  const double hidden_rad =
      2.0 * std::numbers::pi * static_cast<double>(view) / static_cast<double>(kViews);
  Random random(mix(kNoiseSeed, view));
  seen_m.clear();
  for (std::size_t i = 0; i < place.points_m.size(); ++i) {
    Eigen::Vector3d noise_m;
    for (double& coordinate_m : noise_m) coordinate_m = random.uniform(-kNoise_m, kNoise_m);
    if (angle_between(azimuths_rad[i], hidden_rad) > 0.5 * kHidden_rad) {
      seen_m.emplace_back(place.points_m[i] + noise_m);
    }
  }
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
    return kernel_score_alone(*localizer.levels.front().grid, scan, scan.thin_count, T_map_scan,
                              MatchKernel::kFastest);
  };
  const double here = score_at(0);
  if (!(here > 0.0)) return 1.0;
  // First to one side, then to the other: from one step to the next few points change their cell.
  double best = 0.0;
  for (const int side : {1, -1}) {
    for (int steps = kNearest; steps <= kFarthest; ++steps) {
      best = std::max(best, score_at(side * steps));
    }
  }
  return best / here;
}

}  // namespace

VirtualMatch virtual_match(const Localizer& localizer, const VirtualPlace& place) {
  const std::vector<InitialOffset> offsets = initial_offsets(StartPattern{});
  const std::vector<double> azimuths_rad = azimuths_of(place.points_m);
  VirtualMatch result;
  std::vector<Eigen::Vector3d> seen_m;
  ScanForMatch scan;
  SharedClimbs climbs;
  for (std::size_t view = 0; view < kViews; ++view) {
    see_disturbed(place, azimuths_rad, view, seen_m);
    fill_scan_for_match(seen_m, lead_stride(localizer, seen_m.size()), scan);
    climbs.clear();
    for (std::size_t k = view; k < offsets.size(); k += kViews) {
      const Pose T_map_start = start_of(place, offsets[k]);
      const MatchResult found = localize(localizer, scan, T_map_start, {}, &climbs);
      result.error_m += (found.T_map_sensor.translation() - place.p_map_m).norm() /
                        static_cast<double>(offsets.size());
    }
  }
  fill_scan_for_match(place.points_m, lead_stride(localizer, place.points_m.size()), scan);
  result.rival_score = rival_score(localizer, place, scan);
  return result;
}

}  // namespace sightline

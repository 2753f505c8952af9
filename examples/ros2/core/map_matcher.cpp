#include "map_matcher.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace sightline_ros2 {
namespace {

using sightline::LookPlanAnswer;
using sightline::MapLook;
using sightline::MapReader;
using sightline::Result;
using sightline::VehicleLocalizer;

std::array<double, 3> point_of(const sightline_points& points, std::size_t i) {
  const char* const at = static_cast<const char*>(points.first) + i * points.stride_bytes;
  std::array<double, 3> p_m{};
  if (points.is_double != 0) {
    std::memcpy(p_m.data(), at, sizeof p_m);
    return p_m;
  }
  std::array<float, 3> numbers{};
  std::memcpy(numbers.data(), at, sizeof numbers);
  std::copy(numbers.begin(), numbers.end(), p_m.begin());
  return p_m;
}

// No return is at (0, 0, 0) of the sensor that measured it; moved, it would be a point.
bool is_return(const std::array<double, 3>& p_m) {
  const bool is_finite = std::isfinite(p_m[0]) && std::isfinite(p_m[1]) && std::isfinite(p_m[2]);
  return is_finite && !(p_m[0] == 0.0 && p_m[1] == 0.0 && p_m[2] == 0.0);
}

// The library refuses what is no covariance; a filter that has none yet sends zeros.
bool is_known(const Covariance* covariance) {
  if (covariance == nullptr) return false;
  for (std::size_t i = 0; i < 6; ++i) {
    if (!((*covariance)[7 * i] > 0.0)) return false;
  }
  return true;
}

}  // namespace

bool has_matched(const sightline_match& match) {
  return match.stop == SIGHTLINE_CONVERGED || match.stop == SIGHTLINE_ITERATION_LIMIT;
}

double likelihood_of(const sightline_match& match) {
  const double points = std::max(1.0, static_cast<double>(match.point_count));
  return match.nearest_voxel_likelihood * match.scored_points / points;
}

std::vector<float> moved(const sightline_points& points, const PoseRows& T_to_from) {
  std::vector<float> moved_m;
  moved_m.reserve(3 * points.count);
  for (std::size_t i = 0; i < points.count; ++i) {
    const std::array<double, 3> p_m = point_of(points, i);
    if (!is_return(p_m)) continue;
    for (const double number : transformed(T_to_from, p_m)) {
      moved_m.push_back(static_cast<float>(number));
    }
  }
  return moved_m;
}

Result<MapMatcher> MapMatcher::open(const MatcherOptions& options) {
  sightline_localizer_options chosen{};
  chosen.holds_whole_map = options.holds_whole_map ? 1 : 0;
  if (options.T_base_sensor) chosen.T_vehicle_sensor = options.T_base_sensor->data();
  Result<VehicleLocalizer> localizer = VehicleLocalizer::open(options.map_file, chosen);
  if (!localizer) return localizer.error();
  Result<MapReader> map = MapReader::open(options.map_file, localizer->info().localizer);
  if (!map) return map.error();
  MapMatcher matcher(std::move(*map), std::move(*localizer), options);
  const Result<std::vector<sightline::MapSite>> sites = matcher.map_.sites(0);
  if (!sites) return sites.error();
  for (const sightline::MapSite& site : *sites) {
    std::array<double, 3> p_m = site.position_world_m;
    for (std::size_t i = 0; i < 3; ++i) p_m[i] -= matcher.info().export_origin_world_m[i];
    p_m[2] -= matcher.T_base_sensor_[11];
    matcher.route_m_.push_back(p_m);
  }
  return matcher;
}

MapMatcher::MapMatcher(MapReader map, VehicleLocalizer localizer, const MatcherOptions& options)
    : map_(std::move(map)),
      localizer_(std::move(localizer)),
      limit_m_(options.limit_m),
      visible_m_(options.visible_m),
      protection_risk_(options.protection_risk),
      T_base_sensor_{} {
  std::copy_n(localizer_.info().T_vehicle_sensor, T_base_sensor_.size(), T_base_sensor_.begin());
}

// Looks are cut in the sensor's frame. A cloud of several sensors, or one that was moved to the
// vehicle's frame, is cut as if the map's sensor had measured it.
sightline_points MapMatcher::in_sensor(const ScanPoints& scan) {
  if (scan.T_base_points == T_base_sensor_) return scan.points;
  const PoseRows T_sensor_points = product(inverse(T_base_sensor_), scan.T_base_points);
  moved_m_.clear();
  for (std::size_t i = 0; i < scan.points.count; ++i) {
    const std::array<double, 3> p_m = point_of(scan.points, i);
    if (!is_return(p_m)) continue;
    const std::array<double, 3> q_m = transformed(T_sensor_points, p_m);
    moved_m_.insert(moved_m_.end(), q_m.begin(), q_m.end());
  }
  return sightline::points_of(std::span<const double>(moved_m_));
}

PoseRows MapMatcher::world_rows(const Pose& T_map_base) const {
  PoseRows rows = rows_of(T_map_base);
  for (std::size_t i = 0; i < 3; ++i) rows[4 * i + 3] += info().export_origin_world_m[i];
  return rows;
}

MapMatch MapMatcher::as_match(const sightline_match& match) const {
  MapMatch result;
  result.match = match;
  result.pose = pose_of(sightline::pose_rows(match));
  for (std::size_t i = 0; i < 3; ++i) {
    result.pose.position_m[i] -= info().export_origin_world_m[i];
  }
  std::copy_n(match.covariance, 36, result.covariance.begin());
  return result;
}

Result<MapMatch> MapMatcher::match(const ScanPoints& scan, const Pose& T_map_start,
                                   const Covariance* start_covariance, bool is_tracking) {
  const PoseRows T_world_start = world_rows(T_map_start);
  const std::array<double, 3> sensor_m =
      transformed(T_world_start, {T_base_sensor_[3], T_base_sensor_[7], T_base_sensor_[11]});
  Result<LookPlanAnswer> plan = map_.look_plan(sensor_m, limit_m_, is_tracking, visible_m_);
  if (!plan) return plan.error();
  if (!is_tracking) plan->first.look.settles = false;
  sightline_match_options options{};
  if (is_known(start_covariance)) options.start_covariance = start_covariance->data();
  options.protection_risk = protection_risk_;
  const Result<sightline_match> match =
      localizer_.match(in_sensor(scan), T_world_start, *plan, options);
  if (!match) return match.error();
  MapMatch result = as_match(*match);
  const bool is_second = match->look_count > 1;
  result.look = is_second ? plan->second : plan->first.look;
  result.probability =
      is_second ? std::numeric_limits<double>::quiet_NaN() : plan->first.probability;
  return result;
}

Result<sightline_match> MapMatcher::score(const ScanPoints& scan, const Pose& T_map_base,
                                          const MapLook& look) {
  return localizer_.score(in_sensor(scan), world_rows(T_map_base), look);
}

std::optional<double> MapMatcher::height_m(double x_m, double y_m) const {
  const auto away_m = [&](const std::array<double, 3>& p_m) {
    return std::hypot(p_m[0] - x_m, p_m[1] - y_m);
  };
  const auto nearest =
      std::min_element(route_m_.begin(), route_m_.end(),
                       [&](const auto& a_m, const auto& b_m) { return away_m(a_m) < away_m(b_m); });
  if (nearest == route_m_.end()) return std::nullopt;
  return (*nearest)[2];
}

Result<std::vector<MapMatch>> MapMatcher::matches_from(const sightline_points& points,
                                                       const std::vector<Pose>& starts,
                                                       const MapLook& look) const {
  std::vector<MapMatch> matches;
  for (const Pose& start : starts) {
    const Result<sightline_match> match = localizer_.match(points, world_rows(start), look);
    if (!match) return match.error();
    if (!has_matched(*match)) continue;
    matches.push_back(as_match(*match));
    matches.back().look = look;
  }
  std::stable_sort(matches.begin(), matches.end(), [](const MapMatch& a, const MapMatch& b) {
    return likelihood_of(a.match) > likelihood_of(b.match);
  });
  return matches;
}

}  // namespace sightline_ros2

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "map_matcher.h"

// A vehicle's pose from a rough one: a person's click, GNSS. Every start is matched with few points
// first; the best ends of these then with every return.

namespace sightline_ros2 {
namespace {

using sightline::MapLook;
using sightline::Result;

constexpr std::size_t kHeadings = 36;  // a search is right from 5 degrees
constexpr std::uint32_t kFewReturns = 4096;
constexpr std::uint32_t kFewPoints = 256;
constexpr std::size_t kMostMatched = 16;
// A person's click is no better than that.
constexpr double kLeastSigma_m = 0.5;
constexpr double kGoldenAngle_rad = 2.399963229728653;
// More than the error of a match.
constexpr double kElsewhere_m = 1.0;
constexpr double kElsewhere_rad = 0.1;

bool are_elsewhere(const Pose& a, const Pose& b) {
  return distance_m(a.position_m, b.position_m) > kElsewhere_m || turn_rad(a, b) > kElsewhere_rad;
}

// Even over the ellipse of two standard deviations, the start itself first, at every heading.
std::vector<Pose> starts_around(const StampedPose& start, std::size_t count) {
  const double sigma_x_m = std::max(kLeastSigma_m, std::sqrt(std::max(0.0, start.covariance[0])));
  const double sigma_y_m = std::max(kLeastSigma_m, std::sqrt(std::max(0.0, start.covariance[7])));
  const std::size_t places = std::max<std::size_t>(1, count / kHeadings);
  std::vector<Pose> starts;
  for (std::size_t i = 0; i < places; ++i) {
    const double radius = 2.0 * std::sqrt(static_cast<double>(i) / static_cast<double>(places));
    const double angle_rad = kGoldenAngle_rad * static_cast<double>(i);
    for (std::size_t n = 0; n < kHeadings; ++n) {
      Pose pose = start.pose;
      pose.position_m[0] += radius * sigma_x_m * std::cos(angle_rad);
      pose.position_m[1] += radius * sigma_y_m * std::sin(angle_rad);
      const double yaw_rad = 2.0 * std::numbers::pi * static_cast<double>(n) / kHeadings;
      pose.quaternion_xyzw = product(quaternion_of_yaw(yaw_rad), start.pose.quaternion_xyzw);
      starts.push_back(pose);
    }
  }
  return starts;
}

std::vector<Pose> distinct_ends(const std::vector<MapMatch>& matches) {
  std::vector<Pose> ends;
  for (const MapMatch& match : matches) {
    if (ends.size() == kMostMatched) break;
    const bool is_new = std::none_of(
        ends.begin(), ends.end(), [&](const Pose& end) { return !are_elsewhere(end, match.pose); });
    if (is_new) ends.push_back(match.pose);
  }
  return ends;
}

}  // namespace

Result<std::optional<AlignedScan>> MapMatcher::align(const ScanPoints& scan,
                                                     const StampedPose& start,
                                                     std::size_t start_count) {
  const sightline_points points = in_sensor(scan);
  const MapLook every{.range_m = longest_range_m()};
  MapLook few = every;
  few.return_count = kFewReturns;
  few.point_count = kFewPoints;
  const Result<std::vector<MapMatch>> first =
      matches_from(points, starts_around(start, start_count), few);
  if (!first) return first.error();
  const Result<std::vector<MapMatch>> matches = matches_from(points, distinct_ends(*first), every);
  if (!matches) return matches.error();
  if (matches->empty()) return std::optional<AlignedScan>();
  AlignedScan aligned;
  aligned.best = matches->front();
  aligned.likelihood = likelihood_of(aligned.best.match);
  for (const MapMatch& other : *matches) {
    aligned.tried.push_back(other.pose);
    if (!are_elsewhere(other.pose, aligned.best.pose)) continue;
    aligned.likelihood_elsewhere =
        std::max(aligned.likelihood_elsewhere, likelihood_of(other.match));
  }
  return std::optional(aligned);
}

}  // namespace sightline_ros2

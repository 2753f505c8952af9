#include "odometry_localizer.h"

#include <algorithm>
#include <cmath>

#include "vehicle_axes.h"

namespace sightline_ros2 {
namespace {

using sightline::Result;

constexpr std::uint32_t kSearchEvery = 5;  // scans of a lost vehicle: neighbours fail alike
constexpr double kLeastLikelihood = 2.2;
constexpr double kMostElsewhere = 0.8;
constexpr double kLostSigma_m = 1.5;

const char* name_of(TrackState state) {
  if (state == TrackState::kTracking) return "tracking";
  return state == TrackState::kLost ? "lost" : "no pose";
}

}  // namespace

void OdometryLocalizer::set_initial_pose(const StampedPose& T_map_base) {
  initial_ = T_map_base;
  const std::array<double, 3>& p_m = T_map_base.pose.position_m;
  initial_->pose.position_m[2] = matcher_.height_m(p_m[0], p_m[1]).value_or(p_m[2]);
}

// The last pose, moved as odometry measured; the errors of both add up.
StampedPose OdometryLocalizer::predicted(const PoseRows& T_odom_base) const {
  const PoseRows T_last_base = product(inverse(T_odom_last_), T_odom_base);
  const double way_m = std::hypot(T_last_base[3], T_last_base[7], T_last_base[11]);
  const double sigma_m = options_.least_error_m + options_.error_share * way_m;
  const double sigma_rad = options_.least_error_rad + options_.error_rad_per_m * way_m;
  StampedPose start = last_;
  start.pose = pose_of(product(rows_of(last_.pose), T_last_base));
  for (std::size_t i = 0; i < 6; ++i) {
    const double sigma = i < 3 ? sigma_m : sigma_rad;
    start.covariance[7 * i] += sigma * sigma;
  }
  return start;
}

void OdometryLocalizer::found(const MapMatch& match, const PoseRows& T_odom_base,
                              TrackedScan& result) {
  last_.pose = match.pose;
  last_.covariance = match.covariance;
  T_odom_last_ = T_odom_base;
  result.has_pose = true;
  result.match = match;
  result.T_map_odom = product(rows_of(match.pose), inverse(T_odom_base));
}

void OdometryLocalizer::follow(const ScanPoints& scan, const PoseRows& T_odom_base,
                               TrackedScan& result) {
  const StampedPose start = predicted(T_odom_base);
  const Result<MapMatch> match = matcher_.match(scan, start.pose, &start.covariance, true);
  if (!match) {
    result.report.raise(Level::kError, to_string(match.error()));
    return;
  }
  const std::uint32_t integrity = sightline_monitor_add(&monitor_, &match->match);
  if (integrity == SIGHTLINE_INTEGRITY_LOST) {
    state_ = TrackState::kLost;
    lost_count_ = 0;
    result.report.raise(Level::kError, "Matches contradict the map: the vehicle is lost");
    return;
  }
  if (!has_matched(match->match)) {
    result.report.raise(Level::kWarn, "The scan does not constrain the pose: odometry is followed");
    last_ = start;
    T_odom_last_ = T_odom_base;
    return;
  }
  if (integrity == SIGHTLINE_INTEGRITY_DOUBTFUL) {
    result.report.raise(Level::kWarn, "Matches are worse than good ones of such places");
  }
  found(*match, T_odom_base, result);
}

// Around the initial pose, or where odometry takes a lost vehicle.
void OdometryLocalizer::search(const ScanPoints& scan, const PoseRows& T_odom_base,
                               TrackedScan& result) {
  StampedPose start;
  if (initial_) {
    start = *initial_;
  } else {
    start = predicted(T_odom_base);
    start.covariance[0] = start.covariance[7] = kLostSigma_m * kLostSigma_m;
    if (lost_count_++ % kSearchEvery != 0) {
      result.report.raise(Level::kError, "The vehicle is lost");
      return;
    }
  }
  const Result<std::optional<AlignedScan>> aligned =
      matcher_.align(scan, start, options_.start_count);
  if (!aligned) {
    result.report.raise(Level::kError, to_string(aligned.error()));
    return;
  }
  if (!*aligned || (*aligned)->likelihood < kLeastLikelihood ||
      (*aligned)->likelihood_elsewhere > kMostElsewhere * (*aligned)->likelihood) {
    result.report.raise(Level::kWarn, "The scan fits no place, or several, around the given pose");
    return;
  }
  initial_.reset();
  monitor_ = {};
  state_ = TrackState::kTracking;
  found((*aligned)->best, T_odom_base, result);
}

TrackedScan OdometryLocalizer::take(std::int64_t stamp_ns, const ScanPoints& scan,
                                    const PoseRows& T_odom_base) {
  TrackedScan result;
  Report& report = result.report;
  report.name = "localization";
  report.add("topic_time_stamp", stamp_ns);
  if (initial_ || state_ == TrackState::kLost) {
    search(scan, T_odom_base, result);
  } else if (state_ == TrackState::kTracking) {
    follow(scan, T_odom_base, result);
  } else {
    report.raise(Level::kWarn, "No initial pose: publish one on initialpose");
  }
  last_.stamp_ns = stamp_ns;
  report.add("state", std::string(name_of(state_)));
  if (!result.has_pose) return result;
  const sightline_match& match = result.match.match;
  report.add("protection_forward_m", match.protection_m[0]);
  report.add("protection_left_m", match.protection_m[1]);
  report.add("protection_yaw_rad", match.protection_yaw_rad);
  report.add("weak_axes", names_of_weak(match.weak));
  report.add("range_m", result.match.look.range_m);
  report.add("matched_points", match.point_count);
  return result;
}

}  // namespace sightline_ros2

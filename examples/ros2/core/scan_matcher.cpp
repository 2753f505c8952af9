#include "scan_matcher.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "vehicle_axes.h"

namespace sightline_ros2 {
namespace {

using sightline::MapLook;
using sightline::Result;

// A pause after which the vehicle no longer tracks: the next match searches.
constexpr std::int64_t kLongestStep_ns = 2'000'000'000;
constexpr std::size_t kFewPoints = 4096;

std::string metres(double length_m) {
  std::ostringstream text;
  text.precision(3);
  text << std::fixed << length_m << " m";
  return text.str();
}

// Of up to so many points, spread evenly: the farthest one from the vehicle.
double farthest_m(const ScanPoints& scan, std::size_t most) {
  sightline_points some = scan.points;
  const std::size_t stride = 1 + some.count / most;
  some.count = (some.count + stride - 1) / stride;
  some.stride_bytes *= stride;
  const std::vector<float> base_m = moved(some, scan.T_base_points);
  double farthest_m = 0.0;
  for (std::size_t i = 0; i + 2 < base_m.size(); i += 3) {
    farthest_m = std::max(farthest_m,
                          static_cast<double>(std::hypot(base_m[i], base_m[i + 1], base_m[i + 2])));
  }
  return farthest_m;
}

double per_point(const sightline_match& match) {
  return match.score / std::max(1.0, static_cast<double>(match.point_count));
}

const char* name_of_integrity(std::uint32_t integrity) {
  if (integrity == SIGHTLINE_INTEGRITY_OK) return "ok";
  if (integrity == SIGHTLINE_INTEGRITY_DOUBTFUL) return "doubtful";
  return integrity == SIGHTLINE_INTEGRITY_LOST ? "lost" : "unknown";
}

}  // namespace

ScanMatcher::ScanMatcher(MapMatcher matcher, const ScanMatcherOptions& options)
    : matcher_(std::move(matcher)),
      options_(options),
      initial_poses_(options.initial_pose_timeout_s, options.initial_pose_distance_tolerance_m) {}

Report ScanMatcher::add_initial_pose(const StampedPose& pose, const std::string& frame_id) {
  Report report = report_named("initial_pose_subscriber_status");
  report.add("topic_time_stamp", pose.stamp_ns);
  report.add("is_activated", is_activated_);
  if (!is_activated_) {
    report.raise(Level::kWarn, "The node is not activated: call trigger_node_srv");
    return report;
  }
  const bool is_expected = frame_id == options_.map_frame;
  report.add("is_expected_frame_id", is_expected);
  if (is_expected) {
    initial_poses_.add(pose);
  } else {
    report.raise(Level::kError, "The pose is in the frame '" + frame_id + "', expected '" +
                                    options_.map_frame + "'");
  }
  return report;
}

bool ScanMatcher::check_points(const IncomingScan& scan, std::int64_t now_ns, Report& report) {
  const std::size_t count = scan.scan.points.count;
  report.add("topic_time_stamp", scan.stamp_ns);
  report.add("sensor_points_size", count);
  if (count == 0) {
    report.raise(Level::kWarn, "The scan has no points");
    return false;
  }
  const double delay_s = static_cast<double>(now_ns - scan.stamp_ns) * 1e-9;
  report.add("sensor_points_delay_time_sec", delay_s);
  if (delay_s > options_.timeout_s) {
    report.raise(Level::kWarn, "The scan is older than sensor_points.timeout_sec");
  }
  const bool is_transformed = scan.transform_fault.empty();
  report.add("is_succeed_transform_sensor_points", is_transformed);
  if (!is_transformed) {
    report.raise(Level::kError, scan.transform_fault);
    return false;
  }
  double max_m = farthest_m(scan.scan, kFewPoints);
  if (max_m < options_.required_distance_m) max_m = farthest_m(scan.scan, count);
  report.add("sensor_points_max_distance", max_m);
  if (max_m < options_.required_distance_m) {
    report.raise(Level::kWarn, "The farthest point is at " + metres(max_m) +
                                   ", nearer than sensor_points.required_distance");
    return false;
  }
  last_scan_ = scan;
  report.add("is_activated", is_activated_);
  if (!is_activated_)
    report.raise(Level::kWarn, "The node is not activated: call trigger_node_srv");
  return is_activated_;
}

bool ScanMatcher::find_start(const IncomingScan& scan, ScanResult& result) {
  const std::optional<PoseAtTime> initial = initial_poses_.at(scan.stamp_ns);
  result.report.add("is_succeed_interpolate_initial_pose", initial.has_value());
  if (!initial) {
    result.report.raise(Level::kWarn,
                        "No two poses on ekf_pose_with_covariance are near the time of the scan");
    return false;
  }
  result.initial = *initial;
  return true;
}

bool ScanMatcher::match(const IncomingScan& scan, ScanResult& result) {
  Report& report = result.report;
  const bool is_tracking = tracked_ns_ && std::abs(scan.stamp_ns - *tracked_ns_) <= kLongestStep_ns;
  const Pose& start = result.initial.pose.pose;
  const Covariance& covariance = result.initial.pose.covariance;
  const bool is_fused = options_.covariance_of == CovarianceOf::kPose;
  const Result<MapMatch> match =
      matcher_.match(scan.scan, start, is_fused ? &covariance : nullptr, is_tracking);
  report.add("is_set_map_points", match && match->match.stop != SIGHTLINE_NO_OVERLAP);
  if (!match) {
    report.raise(Level::kError, to_string(match.error()));
    return false;
  }
  result.match = *match;
  if (!has_matched(match->match)) {
    const bool is_outside = match->match.stop == SIGHTLINE_NO_OVERLAP;
    report.raise(Level::kWarn, is_outside ? "The map has nothing near the points of the scan"
                                          : "The scan does not constrain the pose");
    return false;
  }
  const Pose& found = match->pose;
  result.is_matched = true;
  if (is_fused) {
    result.fused = *match;
  } else if (options_.has_protection) {
    const Result<MapMatch> fused = matcher_.match(scan.scan, start, &covariance, is_tracking);
    if (fused) result.fused = *fused;
  }
  result.transform_probability = per_point(match->match);
  result.covariance = published_covariance(*match);
  result.initial_to_result = pose_of(product(inverse(rows_of(start)), rows_of(found)));
  result.distance_m = distance_m(start.position_m, found.position_m);
  result.distance_old_m = distance_m(result.initial.before.pose.position_m, found.position_m);
  result.distance_new_m = distance_m(result.initial.after.pose.position_m, found.position_m);
  return true;
}

void ScanMatcher::score_start(const IncomingScan& scan, ScanResult& result) {
  const Result<sightline_match> before =
      matcher_.score(scan.scan, result.initial.pose.pose, result.match.look);
  if (!before) return;
  const double probability = per_point(*before);
  const double likelihood = before->nearest_voxel_likelihood;
  const double found = result.match.match.nearest_voxel_likelihood;
  Report& report = result.report;
  report.add("transform_probability_diff", result.transform_probability - probability);
  report.add("transform_probability_before", probability);
  report.add("nearest_voxel_transformation_likelihood_diff", found - likelihood);
  report.add("nearest_voxel_transformation_likelihood_before", likelihood);
}

bool ScanMatcher::is_good_score(ScanResult& result) {
  Report& report = result.report;
  const sightline_match& match = result.match.match;
  const std::uint32_t integrity = sightline_monitor_add(&monitor_, &match);
  report.add("integrity", std::string(name_of_integrity(integrity)));
  if (options_.converged_by == ConvergedBy::kIntegrity) {
    if (integrity == SIGHTLINE_INTEGRITY_DOUBTFUL) {
      report.raise(Level::kWarn, "Matches are worse than good ones of such places");
    }
    if (integrity == SIGHTLINE_INTEGRITY_LOST) {
      report.raise(Level::kError, "Matches contradict the map: the vehicle is lost");
    }
    return integrity != SIGHTLINE_INTEGRITY_LOST;
  }
  const bool is_by_probability = options_.converged_by == ConvergedBy::kTransformProbability;
  const double score =
      is_by_probability ? result.transform_probability : match.nearest_voxel_likelihood;
  const double least = is_by_probability ? options_.least_transform_probability
                                         : options_.least_nearest_voxel_likelihood;
  if (score > least) return true;
  std::ostringstream text;
  text << "The score is " << score << ", not above the threshold of " << least;
  report.raise(Level::kWarn, text.str());
  return false;
}

void ScanMatcher::report_match(ScanResult& result) {
  Report& report = result.report;
  const sightline_match& match = result.match.match;
  report.add("distance_initial_to_result", result.distance_m);
  if (result.distance_m > options_.initial_to_result_distance_tolerance_m) {
    report.raise(Level::kWarn, "The pose is " + metres(result.distance_m) + " from its start");
  }
  const VehicleSigmas sigmas = sigmas_of(result.match.pose, result.match.covariance);
  report.add("sigma_forward_m", sigmas.forward_m);
  report.add("sigma_left_m", sigmas.left_m);
  report.add("sigma_yaw_rad", sigmas.yaw_rad);
  report.add("weak_axes", names_of_weak(match.weak));
  report.add("range_m", result.match.look.range_m);
  report.add("matched_points", match.point_count);
  report.add("look_count", match.look_count);
}

void ScanMatcher::report_protection(ScanResult& result) {
  if (!result.fused) return;
  Report& report = result.report;
  const sightline_match& fused = result.fused->match;
  report.add("protection_forward_m", fused.protection_m[0]);
  report.add("protection_left_m", fused.protection_m[1]);
  report.add("protection_up_m", fused.protection_m[2]);
  report.add("protection_yaw_rad", fused.protection_yaw_rad);
}

void ScanMatcher::score_no_ground(const IncomingScan& scan, ScanResult& result) {
  if (!options_.has_no_ground_score) return;
  const PoseRows T_map_base = rows_of(result.match.pose);
  NoGroundScore score;
  const std::vector<float> base_m = moved(scan.scan.points, scan.scan.T_base_points);
  for (std::size_t i = 0; i + 2 < base_m.size(); i += 3) {
    const std::array<double, 3> p_m = {base_m[i], base_m[i + 1], base_m[i + 2]};
    const double above_m = transformed(T_map_base, p_m)[2] - T_map_base[11];
    if (above_m > options_.z_margin_m) {
      score.points_base_m.insert(score.points_base_m.end(), p_m.begin(), p_m.end());
    }
  }
  ScanPoints above{sightline::points_of(std::span<const double>(score.points_base_m)),
                   rows_of(Pose())};
  const Result<sightline_match> found =
      matcher_.score(above, result.match.pose, MapLook{.range_m = matcher_.longest_range_m()});
  if (!found) return;
  score.transform_probability = per_point(*found);
  score.nearest_voxel_likelihood = found->nearest_voxel_likelihood;
  result.no_ground = std::move(score);
}

Covariance ScanMatcher::published_covariance(const MapMatch& match) const {
  if (options_.covariance_of == CovarianceOf::kFixedValue) {
    return in_map_axes(match.pose, options_.output_pose_covariance);
  }
  Covariance covariance = match.covariance;
  for (double& number : covariance) number *= options_.covariance_factor;
  return covariance;
}

ScanResult ScanMatcher::take(const IncomingScan& scan, std::int64_t now_ns) {
  const auto begin = std::chrono::steady_clock::now();
  ScanResult result;
  Report& report = result.report;
  report.name = "scan_matching_status";
  if (check_points(scan, now_ns, report) && find_start(scan, result) && match(scan, result)) {
    const sightline_match& found = result.match.match;
    report.add("iteration_num", found.iterations);
    const bool has_converged = found.stop == SIGHTLINE_CONVERGED;
    if (!has_converged) report.raise(Level::kWarn, "The match stopped at its limit of iterations");
    report.add("transform_probability", result.transform_probability);
    report.add("nearest_voxel_transformation_likelihood", found.nearest_voxel_likelihood);
    score_start(scan, result);
    const bool is_good = is_good_score(result);
    result.is_converged = has_converged && is_good;
    report_match(result);
    report_protection(result);
    score_no_ground(scan, result);
    const auto taken = std::chrono::steady_clock::now() - begin;
    result.exe_time_ms = std::chrono::duration<double, std::milli>(taken).count();
    report.add("execution_time", result.exe_time_ms);
    if (result.exe_time_ms > options_.critical_upper_bound_exe_time_ms) {
      report.raise(Level::kWarn,
                   "The scan took longer than validation.critical_upper_bound_exe_time_ms");
    }
  }
  if (result.is_converged) tracked_ns_ = scan.stamp_ns;
  skipped_count_ = result.is_converged || !is_activated_ ? 0 : skipped_count_ + 1;
  report.add("skipping_publish_num", skipped_count_);
  if (skipped_count_ >= options_.skipping_publish_num) {
    report.raise(Level::kWarn, std::to_string(skipped_count_) + " scans in a row gave no pose");
  }
  return result;
}

}  // namespace sightline_ros2

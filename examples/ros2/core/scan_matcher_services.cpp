#include <algorithm>
#include <utility>

#include "scan_matcher.h"

// What the node's services and its timer do.

namespace sightline_ros2 {
namespace {

using sightline::Error;
using sightline::Result;

// Another place at most this share of the best one's likelihood, else a start is not reliable.
constexpr double kMostElsewhere = 0.8;

}  // namespace

Report ScanMatcher::trigger(bool activates, std::int64_t now_ns) {
  Report report = report_named("trigger_node_service_status");
  report.add("service_call_time_stamp", now_ns);
  is_activated_ = activates;
  if (activates) {
    initial_poses_.clear();
    tracked_ns_.reset();
    monitor_ = {};
  }
  report.add("is_activated", is_activated_);
  report.add("is_succeed_service", true);
  return report;
}

AlignResult ScanMatcher::align(const std::optional<StampedPose>& start,
                               const std::string& transform_fault, std::int64_t now_ns) {
  AlignResult result;
  Report& report = result.report;
  report.name = "ndt_align_service_status";
  const auto finish = [&](const std::string& fault, Level level) {
    report.add("is_succeed_service", result.is_success);
    if (!fault.empty()) report.raise(level, fault);
    return std::move(result);
  };
  report.add("service_call_time_stamp", now_ns);
  report.add("is_succeed_transform_initial_pose", start.has_value());
  if (!start) return finish(transform_fault, Level::kError);
  report.add("is_set_sensor_points", last_scan_.has_value());
  if (!last_scan_) return finish("No scan was received on points_raw", Level::kWarn);
  const Result<std::optional<AlignedScan>> aligned =
      matcher_.align(last_scan_->scan, *start,
                     static_cast<std::size_t>(std::max<std::int64_t>(1, options_.particles_num)));
  if (!aligned) return finish(to_string(aligned.error()), Level::kError);
  report.add("is_set_map_points", aligned->has_value());
  if (!*aligned) return finish("The map has nothing near the points of the scan", Level::kWarn);
  const AlignedScan& found = **aligned;
  report.add("best_particle_score", found.likelihood);
  report.add("score_elsewhere", found.likelihood_elsewhere);
  result.is_success = true;
  result.is_reliable = found.likelihood > options_.least_nearest_voxel_likelihood &&
                       found.likelihood_elsewhere <= kMostElsewhere * found.likelihood;
  result.pose = {start->stamp_ns, found.best.pose, published_covariance(found.best)};
  result.tried = found.tried;
  return finish(result.is_reliable ? "" : "Another place is nearly as likely, or none is likely",
                Level::kWarn);
}

Report ScanMatcher::map_status(std::int64_t now_ns) const {
  Report report = report_named("map_update_status");
  report.add("timer_callback_time_stamp", now_ns);
  report.add("is_activated", is_activated_);
  if (!is_activated_)
    report.raise(Level::kWarn, "The node is not activated: call trigger_node_srv");
  const std::vector<Error> faults = matcher_.faults();
  report.add("unreadable_tiles", faults.size());
  for (const Error& fault : faults) report.raise(Level::kError, to_string(fault));
  return report;
}

}  // namespace sightline_ros2

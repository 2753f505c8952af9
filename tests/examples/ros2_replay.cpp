#include "tests/examples/ros2_replay.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "passes/matching/match_starts.h"
#include "passes/replay/pose_rows.h"
#include "passes/replay/straighten.h"

namespace sightline {
namespace {

namespace node = sightline_ros2;

// Of a prediction by constant speed.
constexpr double kSigma_m = 0.1;
constexpr double kSigma_rad = 0.01;
constexpr double kStartSigma_m = 0.5;
// Farther than a vehicle drives between two scans.
constexpr double kFirstStepSigma_m = 1.5;

node::Covariance covariance_of(double sigma_m, double sigma_rad) {
  node::Covariance covariance{};
  for (std::size_t i = 0; i < 6; ++i) {
    covariance[7 * i] = i < 3 ? sigma_m * sigma_m : sigma_rad * sigma_rad;
  }
  return covariance;
}

// The filter, and what it is driven by.
class Filter {
 public:
  Filter(node::ScanMatcher& matcher, const SensorProfile& sensor)
      : matcher_(matcher), sensor_(sensor) {
    const std::array<double, 3>& origin_m = matcher.map().info().export_origin_world_m;
    origin_world_m_ = Eigen::Map<const Eigen::Vector3d>(origin_m.data());
  }

  Result<NodeScan> take(Scan scan);
  void start(const Pose& T_world_vehicle) { T_world_last_ = T_world_vehicle; }

 private:
  [[nodiscard]] node::Pose in_map(const Pose& T_world_vehicle) const;
  [[nodiscard]] Pose in_world(const node::Pose& pose) const;
  [[nodiscard]] node::IncomingScan incoming(const Scan& scan) const;
  NodeScan search(const Scan& scan);
  NodeScan follow(const Scan& scan);
  void found(const Pose& T_world_vehicle, std::int64_t stamp_ns);

  node::ScanMatcher& matcher_;
  const SensorProfile& sensor_;
  Eigen::Vector3d origin_world_m_;
  int found_count_ = 0;
  Pose T_world_last_ = Pose::Identity();
  Pose T_before_last_ = Pose::Identity();
  std::int64_t last_ns_ = 0;
  std::int64_t last_step_ns_ = 0;
};

node::Pose Filter::in_map(const Pose& T_world_vehicle) const {
  node::Pose pose = node::pose_of(rows_of(T_world_vehicle));
  for (std::size_t i = 0; i < 3; ++i) {
    pose.position_m[i] -= origin_world_m_[static_cast<Eigen::Index>(i)];
  }
  return pose;
}

Pose Filter::in_world(const node::Pose& pose) const {
  const PoseRows rows = node::rows_of(pose);
  return Eigen::Translation3d(origin_world_m_) * pose_of(rows.data());
}

node::IncomingScan Filter::incoming(const Scan& scan) const {
  node::IncomingScan incoming;
  incoming.stamp_ns = scan.stamp_ns;
  incoming.scan = {points_of(scan), rows_of(sensor_.T_vehicle_lidar)};
  return incoming;
}

void Filter::found(const Pose& T_world_vehicle, std::int64_t stamp_ns) {
  if (found_count_ > 0) {
    T_before_last_ = T_world_last_.inverse(Eigen::Isometry) * T_world_vehicle;
    last_step_ns_ = stamp_ns - last_ns_;
  }
  T_world_last_ = T_world_vehicle;
  last_ns_ = stamp_ns;
  ++found_count_;
}

// By the service, as pose_initializer does; one pose does not predict the next.
NodeScan Filter::search(const Scan& scan) {
  NodeScan result;
  matcher_.trigger(false, scan.stamp_ns);
  const node::ScanResult waited = matcher_.take(incoming(scan), scan.stamp_ns);
  result.message = waited.report.message;
  const double sigma_m = found_count_ == 0 ? kStartSigma_m : kFirstStepSigma_m;
  const node::StampedPose start{scan.stamp_ns, in_map(T_world_last_), covariance_of(sigma_m, 1.0)};
  const node::AlignResult aligned = matcher_.align(start, "", scan.stamp_ns);
  matcher_.trigger(true, scan.stamp_ns);
  if (!aligned.is_success) return result;
  result.has_pose = true;
  result.T_world_vehicle = in_world(aligned.pose.pose);
  found(result.T_world_vehicle, scan.stamp_ns);
  return result;
}

NodeScan Filter::follow(const Scan& scan) {
  const double factor = static_cast<double>(scan.stamp_ns - last_ns_) /
                        static_cast<double>(std::max<std::int64_t>(1, last_step_ns_));
  const Pose T_world_predicted = predicted_pose(T_world_last_, T_before_last_, factor);
  const node::Covariance covariance = covariance_of(kSigma_m, kSigma_rad);
  const std::string& frame = "map";
  matcher_.add_initial_pose({last_ns_, in_map(T_world_last_), covariance}, frame);
  matcher_.add_initial_pose({scan.stamp_ns, in_map(T_world_predicted), covariance}, frame);
  const node::ScanResult taken = matcher_.take(incoming(scan), scan.stamp_ns);
  NodeScan result;
  result.has_pose = taken.is_converged;
  result.exe_time_ms = taken.exe_time_ms;
  result.message = taken.report.message;
  result.match = taken.match.match;
  result.integrity = taken.match.match.integrity;
  result.T_world_vehicle = taken.is_converged ? in_world(taken.match.pose) : T_world_predicted;
  if (taken.is_converged) found(result.T_world_vehicle, scan.stamp_ns);
  return result;
}

Result<NodeScan> Filter::take(Scan scan) {
  straighten(scan, {T_before_last_, last_step_ns_}, sensor_.T_vehicle_lidar);
  return found_count_ < 2 ? search(scan) : follow(scan);
}

}  // namespace

Result<std::vector<NodeScan>> replay_in_node(const NodeReplayOptions& options,
                                             const ScanStore& store,
                                             const std::vector<ListedScan>& scans,
                                             const SensorProfile& sensor) {
  node::MatcherOptions opened;
  opened.map_file = options.map_file;
  opened.limit_m = options.limit_m;
  opened.holds_whole_map = options.holds_whole_map;
  const PoseRows T_base_sensor = rows_of(sensor.T_vehicle_lidar);
  opened.T_base_sensor = T_base_sensor;
  SIGHTLINE_ASSIGN(node::MapMatcher map, node::MapMatcher::open(opened));
  node::ScanMatcher matcher(std::move(map), {});
  Filter filter(matcher, sensor);
  filter.start(options.T_world_start);
  std::vector<NodeScan> results;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    SIGHTLINE_ASSIGN(Scan scan, store.read(i));
    scan.stamp_ns = scans[i].stamp_ns;
    SIGHTLINE_ASSIGN(NodeScan result, filter.take(std::move(scan)));
    if (i == 0 && !result.has_pose) {
      return Error{ErrorCode::kNoOverlap, "the first scan is not found: " + result.message};
    }
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace sightline

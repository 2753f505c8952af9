#include "localizer_node.h"

#include <algorithm>
#include <chrono>
#include <rclcpp_components/register_node_macro.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "messages.h"

namespace sightline_ros2 {
namespace {

using autoware_internal_debug_msgs::msg::Float32Stamped;
using autoware_internal_debug_msgs::msg::Int32Stamped;
using geometry_msgs::msg::PoseStamped;
using geometry_msgs::msg::PoseWithCovarianceStamped;
using sensor_msgs::msg::PointCloud2;
using visualization_msgs::msg::Marker;
using visualization_msgs::msg::MarkerArray;

Float32Stamped float_of(std::int64_t stamp_ns, double value) {
  Float32Stamped message;
  message.stamp = time_of(stamp_ns);
  message.data = static_cast<float>(value);
  return message;
}

PoseStamped pose_stamped(std::int64_t stamp_ns, const std::string& frame, const Pose& pose) {
  PoseStamped message;
  message.header.stamp = time_of(stamp_ns);
  message.header.frame_id = frame;
  message.pose = message_of(pose);
  return message;
}

}  // namespace

LocalizerNode::LocalizerNode(const rclcpp::NodeOptions& options)
    : Node("sightline_localizer", options), transforms_(*this) {
  sightline::Result<MapMatcher> map = MapMatcher::open(declare_matcher());
  if (!map) throw std::runtime_error(to_string(map.error()));
  if (!map->info().is_for_caller) {
    RCLCPP_WARN(get_logger(),
                "the map holds errors of the localizer '%s', not of this one: it names no look "
                "for it, and every return within the longest range is matched",
                std::string(map->info().localizer).c_str());
  }
  matcher_.emplace(std::move(*map), declare_options());
  advertise();
  advertise_scores();
  listen();
}

MatcherOptions LocalizerNode::declare_matcher() {
  MatcherOptions options;
  options.map_file = declare_parameter<std::string>("map_file");
  options.limit_m = declare_parameter<double>("limit_m", options.limit_m);
  const auto visible_m = declare_parameter<double>("visible_m", 0.0);
  if (visible_m > 0.0) options.visible_m = visible_m;
  options.protection_risk = declare_parameter<double>("protection_risk", 0.01);
  has_protection_ = options.protection_risk > 0.0;
  return options;
}

ScanMatcherOptions LocalizerNode::declare_options() {
  ScanMatcherOptions options;
  base_frame_ = declare_parameter<std::string>("frame.base_frame", "base_link");
  ndt_base_frame_ = declare_parameter<std::string>("frame.ndt_base_frame", "ndt_base_link");
  map_frame_ = declare_parameter<std::string>("frame.map_frame", "map");
  options.map_frame = map_frame_;
  options.has_protection = has_protection_;
  options.timeout_s = declare_parameter<double>("sensor_points.timeout_sec", options.timeout_s);
  options.required_distance_m =
      declare_parameter<double>("sensor_points.required_distance", options.required_distance_m);
  options.particles_num = declare_parameter<std::int64_t>("initial_pose_estimation.particles_num",
                                                          options.particles_num);
  options.initial_pose_timeout_s = declare_parameter<double>("validation.initial_pose_timeout_sec",
                                                             options.initial_pose_timeout_s);
  options.initial_pose_distance_tolerance_m = declare_parameter<double>(
      "validation.initial_pose_distance_tolerance_m", options.initial_pose_distance_tolerance_m);
  options.initial_to_result_distance_tolerance_m =
      declare_parameter<double>("validation.initial_to_result_distance_tolerance_m",
                                options.initial_to_result_distance_tolerance_m);
  options.critical_upper_bound_exe_time_ms = declare_parameter<double>(
      "validation.critical_upper_bound_exe_time_ms", options.critical_upper_bound_exe_time_ms);
  options.skipping_publish_num = declare_parameter<std::int64_t>("validation.skipping_publish_num",
                                                                 options.skipping_publish_num);
  declare_scores(options);
  return options;
}

void LocalizerNode::declare_scores(ScanMatcherOptions& options) {
  const auto converged_by = declare_parameter<std::int64_t>(
      "score_estimation.converged_param_type", static_cast<std::int64_t>(options.converged_by));
  if (converged_by < 0 || converged_by > 2) {
    throw std::runtime_error("score_estimation.converged_param_type: expected 0, 1 or 2");
  }
  options.converged_by = static_cast<ConvergedBy>(converged_by);
  options.least_transform_probability =
      declare_parameter<double>("score_estimation.converged_param_transform_probability",
                                options.least_transform_probability);
  options.least_nearest_voxel_likelihood = declare_parameter<double>(
      "score_estimation.converged_param_nearest_voxel_transformation_likelihood",
      options.least_nearest_voxel_likelihood);
  options.has_no_ground_score =
      declare_parameter<bool>("score_estimation.no_ground_points.enable", false);
  options.z_margin_m = declare_parameter<double>(
      "score_estimation.no_ground_points.z_margin_for_ground_removal", options.z_margin_m);
  const auto kind =
      declare_parameter<std::int64_t>("covariance.covariance_estimation.covariance_estimation_type",
                                      static_cast<std::int64_t>(options.covariance_of));
  if (kind < 0 || kind > 4) {
    throw std::runtime_error(
        "covariance.covariance_estimation.covariance_estimation_type: expected 0 to 4");
  }
  // Autoware's 1 to 3 are ways to compute what the scan shows.
  options.covariance_of = CovarianceOf::kScan;
  if (kind == 0 || kind == 4) options.covariance_of = static_cast<CovarianceOf>(kind);
  options.covariance_factor = declare_parameter<double>(
      "covariance.covariance_estimation.scale_factor", options.covariance_factor);
  std::vector<double> fixed(36, 0.0);
  for (std::size_t i = 0; i < 6; ++i) fixed[7 * i] = i < 3 ? 0.0225 : 0.000625;
  fixed = declare_parameter<std::vector<double>>("covariance.output_pose_covariance", fixed);
  if (fixed.size() != 36) {
    throw std::runtime_error("covariance.output_pose_covariance: expected 36 numbers");
  }
  std::copy(fixed.begin(), fixed.end(), options.output_pose_covariance.begin());
}

void LocalizerNode::advertise() {
  pose_ = create_publisher<PoseStamped>("ndt_pose", 10);
  pose_with_covariance_ =
      create_publisher<PoseWithCovarianceStamped>("ndt_pose_with_covariance", 10);
  initial_pose_ = create_publisher<PoseWithCovarianceStamped>("initial_pose_with_covariance", 10);
  diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", 10);
  points_aligned_ = create_publisher<PointCloud2>("points_aligned", 10);
  no_ground_points_ = create_publisher<PointCloud2>("points_aligned_no_ground", 10);
  relative_pose_ = create_publisher<PoseStamped>("initial_to_result_relative_pose", 10);
  tried_ = create_publisher<MarkerArray>("monte_carlo_initial_pose_marker", 10);
}

void LocalizerNode::advertise_scores() {
  exe_time_ = create_publisher<Float32Stamped>("exe_time_ms", 10);
  transform_probability_ = create_publisher<Float32Stamped>("transform_probability", 10);
  likelihood_ = create_publisher<Float32Stamped>("nearest_voxel_transformation_likelihood", 10);
  no_ground_probability_ = create_publisher<Float32Stamped>("no_ground_transform_probability", 10);
  no_ground_likelihood_ =
      create_publisher<Float32Stamped>("no_ground_nearest_voxel_transformation_likelihood", 10);
  iteration_num_ = create_publisher<Int32Stamped>("iteration_num", 10);
  distance_ = create_publisher<Float32Stamped>("initial_to_result_distance", 10);
  distance_old_ = create_publisher<Float32Stamped>("initial_to_result_distance_old", 10);
  distance_new_ = create_publisher<Float32Stamped>("initial_to_result_distance_new", 10);
}

void LocalizerNode::listen() {
  initial_pose_subscription_ = create_subscription<PoseWithCovarianceStamped>(
      "ekf_pose_with_covariance", rclcpp::QoS(10),
      [this](const PoseWithCovarianceStamped::ConstSharedPtr message) {
        const std::scoped_lock lock(mutex_);
        const StampedPose pose = stamped_pose_of(*message);
        publish(matcher_->add_initial_pose(pose, message->header.frame_id), pose.stamp_ns);
      });
  points_subscription_ = create_subscription<PointCloud2>(
      "points_raw", rclcpp::SensorDataQoS().keep_last(1),
      [this](const PointCloud2::ConstSharedPtr message) { take_points(message); });
  align_service_ = create_service<Align>(
      "ndt_align_srv", [this](const Align::Request::SharedPtr request,
                              Align::Response::SharedPtr response) { align(*request, *response); });
  trigger_service_ = create_service<SetBool>(
      "trigger_node_srv",
      [this](const SetBool::Request::SharedPtr request, SetBool::Response::SharedPtr response) {
        const std::scoped_lock lock(mutex_);
        const std::int64_t now_ns = now().nanoseconds();
        publish(matcher_->trigger(request->data, now_ns), now_ns);
        response->success = true;
      });
  map_status_timer_ = create_wall_timer(std::chrono::seconds(1), [this] {
    const std::scoped_lock lock(mutex_);
    const std::int64_t now_ns = now().nanoseconds();
    publish(matcher_->map_status(now_ns), now_ns);
  });
}

void LocalizerNode::take_points(const PointCloud2::ConstSharedPtr& message) {
  IncomingScan scan;
  scan.stamp_ns = ns_of(message->header.stamp);
  scan.memory = message;
  const std::optional<sightline_points> points = points_of(*message);
  if (points) scan.scan.points = *points;
  if (!points) {
    RCLCPP_WARN(get_logger(),
                "points_raw: expected x, y and z as three floats or doubles in succession, "
                "little-endian, without gaps between rows");
  }
  const std::optional<PoseRows> T_base_points =
      transforms_.find(base_frame_, message->header.frame_id, 0, scan.transform_fault);
  if (T_base_points) scan.scan.T_base_points = *T_base_points;
  const std::scoped_lock lock(mutex_);
  const ScanResult result = matcher_->take(scan, now().nanoseconds());
  if (result.is_matched) {
    publish(result, scan.stamp_ns);
    publish_scores(result, scan.stamp_ns);
    publish_clouds(result, scan);
  }
  publish(result.report, scan.stamp_ns);
}

void LocalizerNode::align(const Align::Request& request, Align::Response& response) {
  std::string fault;
  std::optional<StampedPose> start;
  const PoseWithCovarianceStamped& given = request.pose_with_covariance;
  const std::optional<PoseRows> T_map_given =
      transforms_.find(map_frame_, given.header.frame_id, 0, fault);
  if (T_map_given) {
    start = stamped_pose_of(given);
    start->pose = pose_of(product(*T_map_given, rows_of(start->pose)));
  }
  const std::scoped_lock lock(mutex_);
  const std::int64_t now_ns = now().nanoseconds();
  const AlignResult result = matcher_->align(start, fault, now_ns);
  response.success = result.is_success;
  response.reliable = result.is_reliable;
  if (result.is_success) {
    response.pose_with_covariance = message_of(result.pose, map_frame_);
    publish_tried(result, now_ns);
  }
  publish(result.report, now_ns);
}

void LocalizerNode::publish(const Report& report, std::int64_t stamp_ns) {
  diagnostics_->publish(diagnostics_of(report, get_name(), stamp_ns));
}

void LocalizerNode::publish(const ScanResult& result, std::int64_t stamp_ns) {
  const Pose& pose = result.match.pose;
  initial_pose_->publish(message_of(result.initial.pose, map_frame_));
  transforms_.send(stamp_ns, map_frame_, ndt_base_frame_, pose);
  if (!result.is_converged) return;
  pose_->publish(pose_stamped(stamp_ns, map_frame_, pose));
  pose_with_covariance_->publish(message_of({stamp_ns, pose, result.covariance}, map_frame_));
}

void LocalizerNode::publish_scores(const ScanResult& result, std::int64_t stamp_ns) {
  const sightline_match& match = result.match.match;
  exe_time_->publish(float_of(stamp_ns, result.exe_time_ms));
  transform_probability_->publish(float_of(stamp_ns, result.transform_probability));
  likelihood_->publish(float_of(stamp_ns, match.nearest_voxel_likelihood));
  Int32Stamped iterations;
  iterations.stamp = time_of(stamp_ns);
  iterations.data = match.iterations;
  iteration_num_->publish(iterations);
  relative_pose_->publish(pose_stamped(stamp_ns, map_frame_, result.initial_to_result));
  distance_->publish(float_of(stamp_ns, result.distance_m));
  distance_old_->publish(float_of(stamp_ns, result.distance_old_m));
  distance_new_->publish(float_of(stamp_ns, result.distance_new_m));
  if (!result.no_ground) return;
  no_ground_probability_->publish(float_of(stamp_ns, result.no_ground->transform_probability));
  no_ground_likelihood_->publish(float_of(stamp_ns, result.no_ground->nearest_voxel_likelihood));
}

// To move all points takes longer than the match: only where they are received.
void LocalizerNode::publish_clouds(const ScanResult& result, const IncomingScan& scan) {
  const PoseRows T_map_base = rows_of(result.match.pose);
  if (points_aligned_->get_subscription_count() > 0) {
    const PoseRows T_map_points = product(T_map_base, scan.scan.T_base_points);
    points_aligned_->publish(
        cloud_of(moved(scan.scan.points, T_map_points), scan.stamp_ns, map_frame_));
  }
  if (!result.no_ground || no_ground_points_->get_subscription_count() == 0) return;
  const sightline_points above =
      sightline::points_of(std::span<const double>(result.no_ground->points_base_m));
  no_ground_points_->publish(cloud_of(moved(above, T_map_base), scan.stamp_ns, map_frame_));
}

// Arrows where the searches ended, the best one first.
void LocalizerNode::publish_tried(const AlignResult& result, std::int64_t stamp_ns) {
  MarkerArray markers;
  for (const Pose& pose : result.tried) {
    Marker marker;
    marker.header.stamp = time_of(stamp_ns);
    marker.header.frame_id = map_frame_;
    marker.ns = "result_pose";
    marker.id = static_cast<std::int32_t>(markers.markers.size());
    marker.type = Marker::ARROW;
    marker.action = Marker::ADD;
    marker.pose = message_of(pose);
    marker.scale.x = 1.0;
    marker.scale.y = marker.scale.z = 0.2;
    marker.color.r = markers.markers.empty() ? 0.0F : 1.0F;
    marker.color.g = markers.markers.empty() ? 1.0F : 0.5F;
    marker.color.a = 1.0F;
    markers.markers.push_back(marker);
  }
  tried_->publish(markers);
}

}  // namespace sightline_ros2

RCLCPP_COMPONENTS_REGISTER_NODE(sightline_ros2::LocalizerNode)

#include "nav2_node.h"

#include <rclcpp_components/register_node_macro.hpp>
#include <utility>

#include "messages.h"

namespace sightline_ros2 {

using diagnostic_msgs::msg::DiagnosticArray;
using geometry_msgs::msg::PoseWithCovarianceStamped;
using sensor_msgs::msg::PointCloud2;

Nav2Node::Nav2Node(const rclcpp::NodeOptions& options)
    : LifecycleNode("sightline_localizer", options) {
  matcher_options_.map_file = declare_parameter<std::string>("map_file");
  matcher_options_.limit_m = declare_parameter<double>("limit_m", matcher_options_.limit_m);
  global_frame_ = declare_parameter<std::string>("global_frame_id", "map");
  odom_frame_ = declare_parameter<std::string>("odom_frame_id", "odom");
  base_frame_ = declare_parameter<std::string>("base_frame_id", "base_link");
  transform_tolerance_s_ = declare_parameter<double>("transform_tolerance", 0.5);
  sends_transform_ = declare_parameter<bool>("tf_broadcast", true);
  odometry_options_.error_share =
      declare_parameter<double>("odometry_error_share", odometry_options_.error_share);
  odometry_options_.error_rad_per_m =
      declare_parameter<double>("odometry_error_rad_per_m", odometry_options_.error_rad_per_m);
  const auto is_given = declare_parameter<bool>("set_initial_pose", false);
  StampedPose first;
  first.pose.position_m = {declare_parameter<double>("initial_pose.x", 0.0),
                           declare_parameter<double>("initial_pose.y", 0.0),
                           declare_parameter<double>("initial_pose.z", 0.0)};
  first.pose.quaternion_xyzw =
      quaternion_of_yaw(declare_parameter<double>("initial_pose.yaw", 0.0));
  first.covariance[0] = first.covariance[7] = 1.0;  // m^2, as a person gives it
  if (is_given) first_pose_ = first;
}

Nav2Node::Return Nav2Node::on_configure(const rclcpp_lifecycle::State& /*state*/) {
  sightline::Result<MapMatcher> map = MapMatcher::open(matcher_options_);
  if (!map) {
    RCLCPP_ERROR(get_logger(), "%s", to_string(map.error()).c_str());
    return Return::FAILURE;
  }
  localizer_.emplace(std::move(*map), odometry_options_);
  if (first_pose_) localizer_->set_initial_pose(*first_pose_);
  transforms_.emplace(*this);
  pose_ = create_publisher<PoseWithCovarianceStamped>("amcl_pose", rclcpp::QoS(10));
  diagnostics_ = create_publisher<DiagnosticArray>("/diagnostics", rclcpp::QoS(10));
  listen();
  return Return::SUCCESS;
}

void Nav2Node::listen() {
  initial_pose_subscription_ = create_subscription<PoseWithCovarianceStamped>(
      "initialpose", rclcpp::QoS(10),
      [this](const PoseWithCovarianceStamped::ConstSharedPtr message) {
        take_initial_pose(*message);
      });
  points_subscription_ = create_subscription<PointCloud2>(
      "points", rclcpp::SensorDataQoS().keep_last(1),
      [this](const PointCloud2::ConstSharedPtr message) { take_points(*message); });
}

Nav2Node::Return Nav2Node::on_activate(const rclcpp_lifecycle::State& state) {
  LifecycleNode::on_activate(state);  // of the publishers
  const std::scoped_lock lock(mutex_);
  is_active_ = true;
  return Return::SUCCESS;
}

Nav2Node::Return Nav2Node::on_deactivate(const rclcpp_lifecycle::State& state) {
  {
    const std::scoped_lock lock(mutex_);
    is_active_ = false;
  }
  LifecycleNode::on_deactivate(state);
  return Return::SUCCESS;
}

Nav2Node::Return Nav2Node::on_cleanup(const rclcpp_lifecycle::State& /*state*/) {
  close();
  return Return::SUCCESS;
}

Nav2Node::Return Nav2Node::on_shutdown(const rclcpp_lifecycle::State& /*state*/) {
  close();
  return Return::SUCCESS;
}

void Nav2Node::close() {
  initial_pose_subscription_.reset();
  points_subscription_.reset();
  pose_.reset();
  diagnostics_.reset();
  const std::scoped_lock lock(mutex_);
  is_active_ = false;
  transforms_.reset();
  localizer_.reset();
}

void Nav2Node::take_initial_pose(const PoseWithCovarianceStamped& message) {
  const std::scoped_lock lock(mutex_);
  if (!localizer_) return;
  if (message.header.frame_id != global_frame_) {
    RCLCPP_WARN(get_logger(), "initialpose is in the frame '%s', expected '%s'",
                message.header.frame_id.c_str(), global_frame_.c_str());
    return;
  }
  localizer_->set_initial_pose(stamped_pose_of(message));
}

void Nav2Node::take_points(const PointCloud2& message) {
  const std::scoped_lock lock(mutex_);
  if (!is_active_ || !localizer_ || !transforms_) return;
  const std::int64_t stamp_ns = ns_of(message.header.stamp);
  TrackedScan result;
  result.report.name = "localization";
  const std::optional<sightline_points> points = points_of(message);
  std::string fault = "points: expected x, y and z as three floats or doubles in succession";
  std::optional<PoseRows> T_base_points;
  std::optional<PoseRows> T_odom_base;
  if (points) T_base_points = transforms_->find(base_frame_, message.header.frame_id, 0, fault);
  if (T_base_points) T_odom_base = transforms_->find(odom_frame_, base_frame_, stamp_ns, fault);
  if (T_odom_base) {
    result = localizer_->take(stamp_ns, {*points, *T_base_points}, *T_odom_base);
  } else {
    result.report.raise(Level::kWarn, fault);
  }
  publish(result, stamp_ns);
}

// The transform is valid a little longer than the scan, so that others need not wait for the next.
void Nav2Node::publish(const TrackedScan& result, std::int64_t stamp_ns) {
  diagnostics_->publish(diagnostics_of(result.report, get_name(), stamp_ns));
  if (!result.has_pose) return;
  pose_->publish(message_of({stamp_ns, result.match.pose, result.match.covariance}, global_frame_));
  if (!sends_transform_) return;
  const auto ahead_ns = static_cast<std::int64_t>(transform_tolerance_s_ * 1e9);
  transforms_->send(stamp_ns + ahead_ns, global_frame_, odom_frame_, pose_of(result.T_map_odom));
}

}  // namespace sightline_ros2

RCLCPP_COMPONENTS_REGISTER_NODE(sightline_ros2::Nav2Node)

#pragma once

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <rclcpp_lifecycle/lifecycle_node.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <string>

#include "core/odometry_localizer.h"
#include "transforms.h"

namespace sightline_ros2 {

// Localizes a robot of Nav2 in a compiled map: takes AMCL's place with a LiDAR of many beams.
// Interface: README.md.
class Nav2Node : public rclcpp_lifecycle::LifecycleNode {
 public:
  using Return = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;

  explicit Nav2Node(const rclcpp::NodeOptions& options);

  Return on_configure(const rclcpp_lifecycle::State& state) override;  // opens the map
  Return on_activate(const rclcpp_lifecycle::State& state) override;
  Return on_deactivate(const rclcpp_lifecycle::State& state) override;
  Return on_cleanup(const rclcpp_lifecycle::State& state) override;  // closes it
  Return on_shutdown(const rclcpp_lifecycle::State& state) override;

 private:
  using PoseWithCovariance = geometry_msgs::msg::PoseWithCovarianceStamped;

  void listen();
  void close();
  void take_initial_pose(const PoseWithCovariance& message);
  void take_points(const sensor_msgs::msg::PointCloud2& message);
  void publish(const TrackedScan& result, std::int64_t stamp_ns);

  std::string global_frame_;
  std::string odom_frame_;
  std::string base_frame_;
  double transform_tolerance_s_ = 0.5;
  bool sends_transform_ = true;
  MatcherOptions matcher_options_;
  OdometryOptions odometry_options_;
  std::optional<StampedPose> first_pose_;  // of the parameters

  std::mutex mutex_;
  std::optional<OdometryLocalizer> localizer_;
  std::optional<Transforms> transforms_;
  bool is_active_ = false;
  rclcpp_lifecycle::LifecyclePublisher<PoseWithCovariance>::SharedPtr pose_;
  rclcpp_lifecycle::LifecyclePublisher<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr
      diagnostics_;
  rclcpp::Subscription<PoseWithCovariance>::SharedPtr initial_pose_subscription_;
  rclcpp::Subscription<sensor_msgs::msg::PointCloud2>::SharedPtr points_subscription_;
};

}  // namespace sightline_ros2

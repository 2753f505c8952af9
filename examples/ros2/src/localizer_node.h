#pragma once

#include <autoware_internal_debug_msgs/msg/float32_stamped.hpp>
#include <autoware_internal_debug_msgs/msg/int32_stamped.hpp>
#include <autoware_internal_localization_msgs/srv/pose_with_covariance_stamped.hpp>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/pose_array.hpp>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <std_srvs/srv/set_bool.hpp>
#include <string>
#include <visualization_msgs/msg/marker_array.hpp>

#include "core/scan_matcher.h"
#include "transforms.h"

namespace sightline_ros2 {

// Localizes a vehicle in a compiled map, by the topics, services, parameters and diagnostics of
// Autoware's ndt_scan_matcher. Interface: README.md.
class LocalizerNode : public rclcpp::Node {
 public:
  // Throws std::runtime_error where the map cannot be opened, with what was found.
  explicit LocalizerNode(const rclcpp::NodeOptions& options);

 private:
  using PoseWithCovariance = geometry_msgs::msg::PoseWithCovarianceStamped;
  using Float = autoware_internal_debug_msgs::msg::Float32Stamped;
  using Align = autoware_internal_localization_msgs::srv::PoseWithCovarianceStamped;
  using SetBool = std_srvs::srv::SetBool;

  MatcherOptions declare_matcher();
  ScanMatcherOptions declare_options();
  void declare_scores(ScanMatcherOptions& options);
  void advertise();
  void advertise_scores();
  void listen();
  void take_points(const sensor_msgs::msg::PointCloud2::ConstSharedPtr& message);
  void align(const Align::Request& request, Align::Response& response);
  void publish(const Report& report, std::int64_t stamp_ns);
  void publish(const ScanResult& result, std::int64_t stamp_ns);
  void publish_scores(const ScanResult& result, std::int64_t stamp_ns);
  void publish_clouds(const ScanResult& result, const IncomingScan& scan);
  void publish_tried(const AlignResult& result, std::int64_t stamp_ns);

  std::string base_frame_;
  std::string ndt_base_frame_;
  std::string map_frame_;
  bool has_protection_ = true;
  std::mutex mutex_;  // of the matcher
  std::optional<ScanMatcher> matcher_;
  Transforms transforms_;

  rclcpp::Publisher<geometry_msgs::msg::PoseStamped>::SharedPtr pose_;
  rclcpp::Publisher<PoseWithCovariance>::SharedPtr pose_with_covariance_;
  rclcpp::Publisher<PoseWithCovariance>::SharedPtr initial_pose_;
  rclcpp::Publisher<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr diagnostics_;
  rclcpp::Publisher<sensor_msgs::msg::PointCloud2>::SharedPtr points_aligned_;
  rclcpp::Publisher<sensor_msgs::msg::PointCloud2>::SharedPtr no_ground_points_;
  rclcpp::Publisher<Float>::SharedPtr exe_time_;
  rclcpp::Publisher<Float>::SharedPtr transform_probability_;
  rclcpp::Publisher<Float>::SharedPtr likelihood_;
  rclcpp::Publisher<Float>::SharedPtr no_ground_probability_;
  rclcpp::Publisher<Float>::SharedPtr no_ground_likelihood_;
  rclcpp::Publisher<autoware_internal_debug_msgs::msg::Int32Stamped>::SharedPtr iteration_num_;
  rclcpp::Publisher<geometry_msgs::msg::PoseStamped>::SharedPtr relative_pose_;
  rclcpp::Publisher<Float>::SharedPtr distance_;
  rclcpp::Publisher<Float>::SharedPtr distance_old_;
  rclcpp::Publisher<Float>::SharedPtr distance_new_;
  rclcpp::Publisher<visualization_msgs::msg::MarkerArray>::SharedPtr tried_;
  rclcpp::Subscription<PoseWithCovariance>::SharedPtr initial_pose_subscription_;
  rclcpp::Subscription<sensor_msgs::msg::PointCloud2>::SharedPtr points_subscription_;
  rclcpp::Service<Align>::SharedPtr align_service_;
  rclcpp::Service<SetBool>::SharedPtr trigger_service_;
  rclcpp::TimerBase::SharedPtr map_status_timer_;
};

}  // namespace sightline_ros2

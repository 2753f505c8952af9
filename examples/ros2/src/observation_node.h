#pragma once

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <memory>
#include <optional>
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_msgs/msg/string.hpp>
#include <string>

#include "filter_settings.h"
#include "formats/reader/reader.h"

namespace sightline_ros2 {

// Asks a compiled map at each pose of the vehicle how far to look, publishes the answer, and sets
// Autoware's crop box and random downsample filter by it. Parameters and topics: README.md.
class ObservationNode : public rclcpp::Node {
 public:
  // Throws std::runtime_error where the map cannot be opened, with what was found.
  explicit ObservationNode(const rclcpp::NodeOptions& options);

 private:
  void declare_filters();
  void answer(const geometry_msgs::msg::PoseStamped& pose);
  void publish(const geometry_msgs::msg::PoseStamped& pose, const sightline::LookAnswer& look);
  void publish_diagnostics(const geometry_msgs::msg::PoseStamped& pose, unsigned char level,
                           const std::string& message, const sightline::LookAnswer& look);
  void set_filters(const FilterSettings& settings);
  void set_crop_box(const FilterSettings& settings);

  std::optional<sightline::MapReader> map_;
  double limit_m_ = 0.10;
  double visible_m_ = 0.0;  // at most so far can be seen; 0: as far as it goes
  bool takes_looks_ = false;
  bool has_ray_intersection_ = true;
  double hold_s_ = 1.0;
  FilterOptions filters_;

  std::optional<FilterSettings> wanted_;  // those that were set last
  rclcpp::Time wanted_at_;                // when they, or wider ones, were last asked for
  rclcpp::Publisher<std_msgs::msg::Float64>::SharedPtr range_publisher_;
  rclcpp::Publisher<std_msgs::msg::Float64>::SharedPtr probability_publisher_;
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr look_publisher_;
  rclcpp::Publisher<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr diagnostics_publisher_;
  rclcpp::Subscription<geometry_msgs::msg::PoseStamped>::SharedPtr pose_subscription_;
  std::shared_ptr<rclcpp::AsyncParametersClient> crop_box_;
  std::shared_ptr<rclcpp::AsyncParametersClient> downsample_;
};

}  // namespace sightline_ros2

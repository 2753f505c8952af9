#pragma once

#define RCLCPP_COMPONENTS_REGISTER_NODE(NodeClass) \
  static_assert(std::is_constructible_v<NodeClass, const rclcpp::NodeOptions&>);

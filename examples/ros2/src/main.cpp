#include <cstdio>
#include <exception>
#include <memory>

#include "observation_node.h"

int main(int argc, char** argv) {
  rclcpp::init(argc, argv);
  int status = 0;
  try {
    rclcpp::spin(std::make_shared<sightline_ros2::ObservationNode>(rclcpp::NodeOptions()));
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "observation_node: %s\n", failure.what());
    status = 1;
  }
  rclcpp::shutdown();
  return status;
}

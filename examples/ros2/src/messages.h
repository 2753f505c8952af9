#pragma once

#include <builtin_interfaces/msg/time.hpp>
#include <cstdint>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <optional>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <string>
#include <vector>

#include "core/poses.h"
#include "core/report.h"

// Messages of ROS from and to what the core has.

namespace sightline_ros2 {

std::int64_t ns_of(const builtin_interfaces::msg::Time& time);
builtin_interfaces::msg::Time time_of(std::int64_t ns);

Pose pose_of(const geometry_msgs::msg::Pose& message);
geometry_msgs::msg::Pose message_of(const Pose& pose);
StampedPose stamped_pose_of(const geometry_msgs::msg::PoseWithCovarianceStamped& message);
geometry_msgs::msg::PoseWithCovarianceStamped message_of(const StampedPose& pose,
                                                         const std::string& frame);

PoseRows rows_of(const geometry_msgs::msg::Transform& message);
geometry_msgs::msg::TransformStamped transform_of(std::int64_t stamp_ns, const std::string& parent,
                                                  const std::string& child, const Pose& pose);

// Where x, y and z lie in the message's memory, to which the result refers. None where they are no
// three floats or doubles that follow each other, or bytes are missing.
std::optional<sightline_points> points_of(const sensor_msgs::msg::PointCloud2& message);
// x y z each.
sensor_msgs::msg::PointCloud2 cloud_of(const std::vector<float>& points_m, std::int64_t stamp_ns,
                                       const std::string& frame);

diagnostic_msgs::msg::DiagnosticArray diagnostics_of(const Report& report, const std::string& node,
                                                     std::int64_t stamp_ns);

}  // namespace sightline_ros2

#include "messages.h"

#include <algorithm>
#include <cstring>

namespace sightline_ros2 {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;

using sensor_msgs::msg::PointCloud2;
using sensor_msgs::msg::PointField;

const PointField* field_named(const PointCloud2& message, const std::string& name) {
  for (const PointField& field : message.fields) {
    if (field.name == name) return &field;
  }
  return nullptr;
}

PointField float_field(const std::string& name, std::uint32_t offset) {
  PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = PointField::FLOAT32;
  field.count = 1;
  return field;
}

}  // namespace

std::int64_t ns_of(const builtin_interfaces::msg::Time& time) {
  return time.sec * kNsPerS + time.nanosec;
}

builtin_interfaces::msg::Time time_of(std::int64_t ns) {
  builtin_interfaces::msg::Time time;
  time.sec = static_cast<std::int32_t>(ns / kNsPerS);
  time.nanosec = static_cast<std::uint32_t>(ns % kNsPerS);
  return time;
}

Pose pose_of(const geometry_msgs::msg::Pose& message) {
  const auto& p = message.position;
  const auto& q = message.orientation;
  return {{p.x, p.y, p.z}, {q.x, q.y, q.z, q.w}};
}

geometry_msgs::msg::Pose message_of(const Pose& pose) {
  geometry_msgs::msg::Pose message;
  message.position.x = pose.position_m[0];
  message.position.y = pose.position_m[1];
  message.position.z = pose.position_m[2];
  message.orientation.x = pose.quaternion_xyzw[0];
  message.orientation.y = pose.quaternion_xyzw[1];
  message.orientation.z = pose.quaternion_xyzw[2];
  message.orientation.w = pose.quaternion_xyzw[3];
  return message;
}

StampedPose stamped_pose_of(const geometry_msgs::msg::PoseWithCovarianceStamped& message) {
  StampedPose pose{ns_of(message.header.stamp), pose_of(message.pose.pose), {}};
  for (std::size_t i = 0; i < pose.covariance.size(); ++i) {
    pose.covariance[i] = message.pose.covariance[i];
  }
  return pose;
}

geometry_msgs::msg::PoseWithCovarianceStamped message_of(const StampedPose& pose,
                                                         const std::string& frame) {
  geometry_msgs::msg::PoseWithCovarianceStamped message;
  message.header.stamp = time_of(pose.stamp_ns);
  message.header.frame_id = frame;
  message.pose.pose = message_of(pose.pose);
  for (std::size_t i = 0; i < pose.covariance.size(); ++i) {
    message.pose.covariance[i] = pose.covariance[i];
  }
  return message;
}

PoseRows rows_of(const geometry_msgs::msg::Transform& message) {
  const auto& p = message.translation;
  const auto& q = message.rotation;
  return sightline::pose_rows({p.x, p.y, p.z}, {q.x, q.y, q.z, q.w});
}

geometry_msgs::msg::TransformStamped transform_of(std::int64_t stamp_ns, const std::string& parent,
                                                  const std::string& child, const Pose& pose) {
  geometry_msgs::msg::TransformStamped message;
  message.header.stamp = time_of(stamp_ns);
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform.translation.x = pose.position_m[0];
  message.transform.translation.y = pose.position_m[1];
  message.transform.translation.z = pose.position_m[2];
  message.transform.rotation = message_of(pose).orientation;
  return message;
}

std::optional<sightline_points> points_of(const PointCloud2& message) {
  const PointField* const x = field_named(message, "x");
  const PointField* const y = field_named(message, "y");
  const PointField* const z = field_named(message, "z");
  if (x == nullptr || y == nullptr || z == nullptr || message.is_bigendian) return std::nullopt;
  const bool is_double = x->datatype == PointField::FLOAT64;
  const bool is_number = is_double || x->datatype == PointField::FLOAT32;
  const std::uint32_t size = is_double ? 8 : 4;
  const std::size_t count = static_cast<std::size_t>(message.width) * message.height;
  const bool is_row = y->datatype == x->datatype && z->datatype == x->datatype &&
                      y->offset == x->offset + size && z->offset == x->offset + 2 * size;
  const bool has_all =
      message.point_step >= x->offset + 3 * size &&
      message.data.size() / std::max(1U, message.point_step) >= count &&
      (message.height <= 1 || message.row_step == message.width * message.point_step);
  if (!is_number || !is_row || !has_all) return std::nullopt;
  if (count == 0) return sightline_points{nullptr, 0, message.point_step, is_double ? 1 : 0};
  return sightline_points{message.data.data() + x->offset, count, message.point_step,
                          is_double ? 1 : 0};
}

PointCloud2 cloud_of(const std::vector<float>& points_m, std::int64_t stamp_ns,
                     const std::string& frame) {
  PointCloud2 message;
  message.header.stamp = time_of(stamp_ns);
  message.header.frame_id = frame;
  message.height = 1;
  message.width = static_cast<std::uint32_t>(points_m.size() / 3);
  message.fields = {float_field("x", 0), float_field("y", 4), float_field("z", 8)};
  message.point_step = 12;
  message.row_step = 12 * message.width;
  message.is_dense = true;
  message.data.resize(message.row_step);
  if (!points_m.empty()) std::memcpy(message.data.data(), points_m.data(), message.data.size());
  return message;
}

diagnostic_msgs::msg::DiagnosticArray diagnostics_of(const Report& report, const std::string& node,
                                                     std::int64_t stamp_ns) {
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.level = static_cast<unsigned char>(report.level);
  status.name = node + ": " + report.name;
  status.hardware_id = node;
  status.message = report.level == Level::kOk ? "OK" : report.message;
  for (const auto& [key, value] : report.values) {
    diagnostic_msgs::msg::KeyValue pair;
    pair.key = key;
    pair.value = value;
    status.values.push_back(pair);
  }
  diagnostic_msgs::msg::DiagnosticArray all;
  all.header.stamp = time_of(stamp_ns);
  all.status.push_back(status);
  return all;
}

}  // namespace sightline_ros2

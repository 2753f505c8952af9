#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "formats/foreign/ros/files/open_message_log.h"
#include "formats/foreign/text/geodetic_track.h"
#include "formats/foreign/text/pose_file.h"

// Messages of ROS 1 and ROS 2 with poses, places and turn rates; their types are named as in ROS 1.

namespace sightline {

struct MessageHeader {
  std::int64_t stamp_ns = 0;
  std::string frame;  // without a leading slash
};

// Reads the fields of a message in turn. CDR (XCDR1, and XCDR2 of types that are final, as those of
// ROS 2 are): each number stands at a multiple of its size behind the 4 bytes that name the byte
// order. Reads stop at the first failure: from there on each gives zero and ok() is false.
class MessageReader {
 public:
  MessageReader(std::span<const std::byte> message, MessageEncoding encoding);

  template <class T>
  requires std::is_arithmetic_v<T> T get() {
    align(sizeof(T));
    std::array<std::byte, sizeof(T)> raw{};
    const std::span<const std::byte> bytes = take(raw.size());
    if (!ok_) return T{};
    std::ranges::copy(bytes, raw.begin());
    if (is_swapped_) std::ranges::reverse(raw);
    T value{};
    std::memcpy(&value, raw.data(), sizeof value);
    return value;
  }
  std::string text();
  // The length of a sequence of elements of at least `element_size` bytes, which must remain.
  std::uint32_t count(std::size_t element_size);
  // The next bytes as they lie.
  std::span<const std::byte> take(std::size_t size);
  // A time: seconds and nanoseconds.
  std::int64_t time_ns();
  // std_msgs/Header.
  MessageHeader header();

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t offset() const { return offset_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - offset_; }

 private:
  void align(std::size_t size);

  std::span<const std::byte> bytes_;
  std::size_t offset_ = 0;
  std::size_t origin_ = 0;  // alignment counts from here
  std::size_t widest_alignment_ = 1;
  bool is_cdr_ = false;
  bool is_swapped_ = false;
  bool ok_ = true;
};

// nav_msgs/Odometry, geometry_msgs/PoseStamped, PoseWithCovarianceStamped or TransformStamped.
bool is_pose_message(std::string_view datatype);

// tf2_msgs/TFMessage, or tf/tfMessage of older recordings.
bool is_transforms_message(std::string_view datatype);

// Of a message that begins with a std_msgs/Header. Error: malformed-header.
Result<MessageHeader> header_of(std::span<const std::byte> message, MessageEncoding encoding,
                                const std::string& file);

// The stamp and pose of a message of one of the types of is_pose_message. Errors:
// malformed-pose, not-a-rotation.
Result<PoseRow> parse_pose_message(std::span<const std::byte> message, std::string_view datatype,
                                   const std::string& file,
                                   MessageEncoding encoding = MessageEncoding::kRos1);

// sensor_msgs/NavSatFix: a place in degrees, height above the ellipsoid. Nothing where the receiver
// had no fix. Error: malformed-pose (short, or no place on Earth).
inline constexpr std::string_view kNavSatFix = "sensor_msgs/NavSatFix";
Result<std::optional<GeodeticFix>> parse_fix_message(std::span<const std::byte> message,
                                                     const std::string& file,
                                                     MessageEncoding encoding);

// sensor_msgs/Imu: angular velocity and specific force about the axes of the header's frame.
// Nothing where the message is short, or its angular velocity is not finite, is marked as unknown
// (its covariance begins with -1) or is above 100 rad/s, which no unit on a vehicle measures. No
// force where it is marked as unknown, all zero, not finite or above 1000 m/s2.
inline constexpr std::string_view kImu = "sensor_msgs/Imu";
struct ImuMessage {
  MessageHeader header;
  Eigen::Vector3d rate_rad_per_s = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> force_m_s2;
};
std::optional<ImuMessage> parse_imu_message(std::span<const std::byte> message,
                                            MessageEncoding encoding);

// geometry_msgs/TwistStamped, TwistWithCovarianceStamped, VelocityReport of autoware_vehicle_msgs
// and autoware_auto_vehicle_msgs, or nav_msgs/Odometry.
bool is_speed_message(std::string_view datatype);

// The speed along the x axis of a message of one of these types. Nothing where the message is
// short, or its speed is not finite or above 150 m/s.
struct SpeedMessage {
  MessageHeader header;
  double speed_m_s = 0.0;
};
std::optional<SpeedMessage> parse_speed_message(std::span<const std::byte> message,
                                                std::string_view datatype,
                                                MessageEncoding encoding);

// One frame within another. Names are without a leading slash.
struct StampedTransform {
  std::int64_t stamp_ns = 0;
  std::string parent;
  std::string child;
  Pose T_parent_child = Pose::Identity();
};

// Those of a message of is_transforms_message. Errors: malformed-pose, not-a-rotation.
Result<std::vector<StampedTransform>> parse_transforms(std::span<const std::byte> message,
                                                       const std::string& file,
                                                       MessageEncoding encoding);

}  // namespace sightline

#include "formats/foreign/ros/ros_messages.h"

#include <cmath>

#include "formats/base/units.h"

namespace sightline {
namespace {

// A position and a quaternion x y z w. Errors: malformed-pose, not-a-rotation.
Result<Pose> take_pose(MessageReader& reader, std::int64_t stamp_ns, const std::string& file) {
  constexpr double kTolerance = 1e-3;  // of the quaternion's norm, as for pose files
  std::array<double, 7> n{};
  for (double& number : n) number = reader.get<double>();
  const bool are_finite = std::ranges::all_of(n, [](double v) { return std::isfinite(v); });
  if (!reader.ok() || !are_finite) {
    return Error{ErrorCode::kMalformedPose, "a pose message is cut short or not finite", file};
  }
  const Eigen::Quaterniond rotation(n[6], n[3], n[4], n[5]);
  if (!(std::abs(rotation.norm() - 1.0) <= kTolerance)) {
    return Error{
        ErrorCode::kNotARotation,
        concat("the norm of the quaternion is ", format_double(rotation.norm()), ", expected 1"),
        file, concat("time ", format_stamp(stamp_ns), " s")};
  }
  Pose pose = Pose::Identity();
  pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(n[0], n[1], n[2]);
  return pose;
}

}  // namespace

bool is_transforms_message(std::string_view datatype) {
  return datatype == "tf2_msgs/TFMessage" || datatype == "tf/tfMessage";
}

bool is_pose_message(std::string_view datatype) {
  return datatype == "nav_msgs/Odometry" || datatype == "geometry_msgs/PoseStamped" ||
         datatype == "geometry_msgs/PoseWithCovarianceStamped" ||
         datatype == "geometry_msgs/TransformStamped";
}

Result<MessageHeader> header_of(std::span<const std::byte> message, MessageEncoding encoding,
                                const std::string& file) {
  MessageReader reader(message, encoding);
  MessageHeader header = reader.header();
  if (reader.ok()) return header;
  return Error{ErrorCode::kMalformedHeader, "the message is shorter than its header", file};
}

Result<PoseRow> parse_pose_message(std::span<const std::byte> message, std::string_view datatype,
                                   const std::string& file, MessageEncoding encoding) {
  MessageReader reader(message, encoding);
  PoseRow row;
  row.stamp_ns = reader.header().stamp_ns;
  const bool names_a_child =
      datatype == "nav_msgs/Odometry" || datatype == "geometry_msgs/TransformStamped";
  if (names_a_child) reader.text();
  SIGHTLINE_ASSIGN(row.T_world_vehicle, take_pose(reader, *row.stamp_ns, file));
  return row;
}

Result<std::optional<GeodeticFix>> parse_fix_message(std::span<const std::byte> message,
                                                     const std::string& file,
                                                     MessageEncoding encoding) {
  MessageReader reader(message, encoding);
  GeodeticFix fix;
  fix.stamp_ns = reader.header().stamp_ns;
  const auto status = reader.get<std::int8_t>();  // NavSatStatus: below 0 there is no fix
  reader.get<std::uint16_t>();                    // service
  fix.at.latitude_deg = reader.get<double>();
  fix.at.longitude_deg = reader.get<double>();
  fix.at.altitude_m = reader.get<double>();
  if (!reader.ok()) return Error{ErrorCode::kMalformedPose, "a NavSatFix is cut short", file};
  if (status < 0) return std::optional<GeodeticFix>();
  const bool is_on_earth = std::abs(fix.at.latitude_deg) <= 90.0 &&
                           std::abs(fix.at.longitude_deg) <= 360.0 &&
                           std::abs(fix.at.altitude_m) < 1e5;
  if (is_on_earth) return std::optional<GeodeticFix>(fix);
  return Error{ErrorCode::kMalformedPose, "a NavSatFix is not a position on Earth", file};
}

// sensor_msgs, msg/Imu.msg: orientation, angular velocity and acceleration, each before its
// covariance of nine numbers.
std::optional<ImuMessage> parse_imu_message(std::span<const std::byte> message,
                                            MessageEncoding encoding) {
  constexpr double kFastest_radps = 100.0;
  constexpr double kLargest_m_s2 = 1000.0;
  constexpr int kOrientation = 4 + 9;
  constexpr int kRestOfCovariance = 8;
  MessageReader reader(message, encoding);
  ImuMessage imu;
  imu.header = reader.header();
  for (int i = 0; i < kOrientation; ++i) reader.get<double>();
  for (double& rate : imu.rate_rad_per_s) rate = reader.get<double>();
  const auto covariance = reader.get<double>();
  for (int i = 0; i < kRestOfCovariance; ++i) reader.get<double>();
  Eigen::Vector3d force_m_s2;
  for (double& axis : force_m_s2) axis = reader.get<double>();
  const auto force_covariance = reader.get<double>();
  for (int i = 0; i < kRestOfCovariance; ++i) reader.get<double>();
  const bool is_rate = imu.rate_rad_per_s.norm() < kFastest_radps;  // not of what is not a number
  if (!reader.ok() || !is_rate || covariance == -1.0) return std::nullopt;
  const double force = force_m_s2.norm();
  if (force > 0.0 && force < kLargest_m_s2 && force_covariance != -1.0) imu.force_m_s2 = force_m_s2;
  return imu;
}

bool is_speed_message(std::string_view datatype) {
  return datatype == "geometry_msgs/TwistStamped" ||
         datatype == "geometry_msgs/TwistWithCovarianceStamped" ||
         datatype == "autoware_vehicle_msgs/VelocityReport" ||
         datatype == "autoware_auto_vehicle_msgs/VelocityReport" || datatype == "nav_msgs/Odometry";
}

// VelocityReport: longitudinal and lateral velocity and heading rate, float32 each. A twist: linear
// and angular velocity, then its covariance. Odometry: a child frame, and a pose with its
// covariance before them.
std::optional<SpeedMessage> parse_speed_message(std::span<const std::byte> message,
                                                std::string_view datatype,
                                                MessageEncoding encoding) {
  constexpr double kFastest_m_s = 150.0;
  constexpr int kPose = 7;
  constexpr int kRestOfTwist = 5;
  constexpr int kCovariance = 36;
  MessageReader reader(message, encoding);
  const auto skip = [&reader](int numbers) {
    for (int i = 0; i < numbers; ++i) reader.get<double>();
  };
  SpeedMessage speed;
  speed.header = reader.header();
  if (datatype.ends_with("VelocityReport")) {
    speed.speed_m_s = static_cast<double>(reader.get<float>());
    for (int i = 0; i < 2; ++i) reader.get<float>();
  } else {
    const bool is_odometry = datatype == "nav_msgs/Odometry";
    if (is_odometry) reader.text();
    if (is_odometry) skip(kPose + kCovariance);
    speed.speed_m_s = reader.get<double>();
    skip(kRestOfTwist);
    if (datatype != "geometry_msgs/TwistStamped") skip(kCovariance);
  }
  const bool is_speed = std::abs(speed.speed_m_s) < kFastest_m_s;  // not of what is not a number
  if (!reader.ok() || !is_speed) return std::nullopt;
  return speed;
}

Result<std::vector<StampedTransform>> parse_transforms(std::span<const std::byte> message,
                                                       const std::string& file,
                                                       MessageEncoding encoding) {
  constexpr std::size_t kLeastSize = 60;  // without frames
  MessageReader reader(message, encoding);
  const std::uint32_t count = reader.count(kLeastSize);
  std::vector<StampedTransform> transforms;
  for (std::uint32_t i = 0; reader.ok() && i < count; ++i) {
    StampedTransform& transform = transforms.emplace_back();
    MessageHeader header = reader.header();
    transform.stamp_ns = header.stamp_ns;
    transform.parent = std::move(header.frame);
    transform.child = reader.text();
    if (transform.child.starts_with('/')) transform.child.erase(0, 1);
    SIGHTLINE_ASSIGN(transform.T_parent_child, take_pose(reader, transform.stamp_ns, file));
  }
  if (reader.ok()) return transforms;
  return Error{ErrorCode::kMalformedPose, "a message of transforms is cut short", file};
}

MessageReader::MessageReader(std::span<const std::byte> message, MessageEncoding encoding)
    : bytes_(message), is_cdr_(encoding == MessageEncoding::kCdr) {
  if (!is_cdr_) return;
  // DDS-XTypes 1.3, 7.6.3.1.2: a kind in two bytes, big-endian, and two of options.
  constexpr unsigned kXcdr2 = 6;
  const std::span<const std::byte> begin = take(4);
  if (!ok_) return;
  const auto kind =
      (std::to_integer<unsigned>(begin[0]) << 8U) + std::to_integer<unsigned>(begin[1]);
  ok_ = kind < 2 || kind == kXcdr2 || kind == kXcdr2 + 1;
  is_swapped_ = kind % 2 == 0;
  origin_ = offset_;
  widest_alignment_ = kind < 2 ? 8 : 4;
}

void MessageReader::align(std::size_t size) {
  if (!is_cdr_) return;
  const std::size_t step = std::min(size, widest_alignment_);
  const std::size_t past = (offset_ - origin_) % step;
  if (past > 0) take(step - past);
}

std::span<const std::byte> MessageReader::take(std::size_t size) {
  if (ok_ && remaining() < size) ok_ = false;
  if (!ok_) return {};
  const std::span<const std::byte> taken = bytes_.subspan(offset_, size);
  offset_ += size;
  return taken;
}

std::uint32_t MessageReader::count(std::size_t element_size) {
  const auto count = get<std::uint32_t>();
  if (ok_ && count > remaining() / element_size) ok_ = false;
  return ok_ ? count : 0;
}

std::string MessageReader::text() {
  const std::uint32_t size = count(1);
  const std::span<const std::byte> bytes = take(size);
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (is_cdr_ && !text.empty()) text.pop_back();  // CDR counts the zero at the end
  return text;
}

std::int64_t MessageReader::time_ns() {
  const std::int64_t seconds =
      is_cdr_ ? std::int64_t{get<std::int32_t>()} : std::int64_t{get<std::uint32_t>()};
  return seconds * kSecond_ns + std::int64_t{get<std::uint32_t>()};
}

MessageHeader MessageReader::header() {
  if (!is_cdr_) get<std::uint32_t>();  // ROS 1 counts its messages
  MessageHeader header;
  header.stamp_ns = time_ns();
  header.frame = text();
  if (header.frame.starts_with('/')) header.frame.erase(0, 1);
  return header;
}

}  // namespace sightline

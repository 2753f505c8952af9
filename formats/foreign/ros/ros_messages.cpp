#include "formats/foreign/ros/ros_messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "formats/foreign/clouds/element_type.h"
#include "formats/foreign/clouds/points/add_point.h"
#include "formats/foreign/clouds/points/point_cloud_file.h"
#include "formats/foreign/clouds/points/point_times.h"
#include "formats/foreign/ros/message_reader.h"
#include "formats/foreign/text/field_names.h"
#include "formats/foreign/text/file_bytes.h"

namespace sightline {
namespace {

struct CloudField {
  std::size_t offset = 0;
  ElementType type;
  bool is_there = false;
};

// What of a PointCloud2 is needed to walk over its points.
struct CloudLayout {
  std::uint64_t height = 0;
  std::uint64_t width = 0;
  std::array<CloudField, 3> position;
  CloudField intensity;
  CloudField time;
  bool is_bigendian = false;
  std::uint64_t point_step = 0;
  std::uint64_t row_step = 0;
  std::size_t data_offset = 0;
  std::uint64_t data_size = 0;
};

// The numbers that sensor_msgs/PointField gives to types, from 1 on.
std::optional<ElementType> field_type(std::uint8_t number) {
  using enum ElementKind;
  constexpr std::array<ElementType, 8> kTypes = {{{kSigned, 1},
                                                  {kUnsigned, 1},
                                                  {kSigned, 2},
                                                  {kUnsigned, 2},
                                                  {kSigned, 4},
                                                  {kUnsigned, 4},
                                                  {kFloat, 4},
                                                  {kFloat, 8}}};
  if (number < 1 || number > kTypes.size()) return std::nullopt;
  return kTypes[number - 1U];
}

void take_field(MessageReader& reader, CloudLayout& layout) {
  const std::string name = reader.text();
  CloudField field;
  field.offset = reader.get<std::uint32_t>();
  const std::optional<ElementType> type = field_type(reader.get<std::uint8_t>());
  reader.get<std::uint32_t>();  // how many; one, or the first one counts
  if (!type) return;
  field.type = *type;
  field.is_there = true;
  if (name == "x") layout.position[0] = field;
  if (name == "y") layout.position[1] = field;
  if (name == "z") layout.position[2] = field;
  if (is_intensity_name(name)) layout.intensity = field;
  if (is_time_name(name)) layout.time = field;
}

CloudLayout take_layout(MessageReader& reader) {
  CloudLayout layout;
  reader.header();
  layout.height = reader.get<std::uint32_t>();
  layout.width = reader.get<std::uint32_t>();
  const auto fields = reader.get<std::uint32_t>();
  for (std::uint32_t i = 0; reader.ok() && i < fields; ++i) take_field(reader, layout);
  layout.is_bigendian = reader.get<std::uint8_t>() != 0;
  layout.point_step = reader.get<std::uint32_t>();
  layout.row_step = reader.get<std::uint32_t>();
  layout.data_size = reader.get<std::uint32_t>();
  layout.data_offset = reader.offset();
  return layout;
}

Result<void> check_layout(const CloudLayout& layout, const FileBytes& file) {
  const auto& [x, y, z] = layout.position;
  if (!x.is_there || !y.is_there || !z.is_there) {
    return file.error(ErrorCode::kMissingField, "no fields x, y and z", at_byte(0));
  }
  if (layout.width == 0 || layout.height == 0) {
    return file.error(ErrorCode::kEmptyScan, "the message says that there are no points",
                      at_byte(0));
  }
  for (const CloudField& field : {x, y, z, layout.intensity, layout.time}) {
    if (field.offset + field.type.size <= layout.point_step || !field.is_there) continue;
    return file.error(ErrorCode::kMalformedHeader, "a field lies outside its point", at_byte(0));
  }
  if (layout.row_step < layout.width * layout.point_step) {
    return file.error(ErrorCode::kMalformedHeader, "a row is shorter than its points", at_byte(0));
  }
  const std::uint64_t left = file.bytes.size() - layout.data_offset;
  if (layout.data_size > left || layout.height > layout.data_size / layout.row_step) {
    return file.error(ErrorCode::kTruncatedScan,
                      "found " + std::to_string(std::min(left, layout.data_size)) +
                          " bytes of points, expected " + std::to_string(layout.height) +
                          " rows of " + std::to_string(layout.row_step),
                      at_byte(layout.data_offset));
  }
  return {};
}

double read_field(const std::uint8_t* point, const CloudField& field, bool is_bigendian) {
  if (!field.is_there) return 0.0;
  return is_bigendian ? read_big_endian_element(point + field.offset, field.type)
                      : read_element(point + field.offset, field.type);
}

// A position and a quaternion x y z w. Errors: malformed-pose, not-a-rotation.
Result<Pose> take_pose(MessageReader& reader, std::int64_t stamp_ns, const std::string& file) {
  constexpr double kTolerance = 1e-3;  // of the quaternion's norm, as for pose files
  std::array<double, 7> n{};
  for (double& number : n) number = reader.get<double>();
  const bool are_finite = std::ranges::all_of(n, [](double v) { return std::isfinite(v); });
  if (!reader.ok() || !are_finite) {
    return Error{ErrorCode::kMalformedPose, "a pose message that is short or not finite", file};
  }
  const Eigen::Quaterniond rotation(n[6], n[3], n[4], n[5]);
  if (!(std::abs(rotation.norm() - 1.0) <= kTolerance)) {
    return Error{ErrorCode::kNotARotation,
                 "the norm of the quaternion is " + format_double(rotation.norm()) + ", expected 1",
                 file, "time " + format_stamp(stamp_ns) + " s"};
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

Result<PointCloudFile> parse_point_cloud2(std::span<const std::byte> message,
                                          const std::string& name, MessageEncoding encoding) {
  const FileBytes file{message, name};
  MessageReader reader(message, encoding);
  const CloudLayout layout = take_layout(reader);
  if (!reader.ok()) {
    return file.error(ErrorCode::kMalformedHeader, "the message ends before its points",
                      at_byte(reader.offset()));
  }
  SIGHTLINE_TRY(check_layout(layout, file));
  PointCloudFile cloud;
  std::vector<double> times;
  const auto* data = reinterpret_cast<const std::uint8_t*>(message.data()) + layout.data_offset;
  for (std::uint64_t i = 0; i < layout.height * layout.width; ++i) {
    const std::uint8_t* point =
        data + i / layout.width * layout.row_step + i % layout.width * layout.point_step;
    Eigen::Vector3d point_m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      point_m[static_cast<Eigen::Index>(axis)] =
          read_field(point, layout.position[axis], layout.is_bigendian);
    }
    const double intensity = read_field(point, layout.intensity, layout.is_bigendian);
    if (add_point(cloud, point_m, static_cast<float>(intensity)) && layout.time.is_there) {
      times.push_back(read_field(point, layout.time, layout.is_bigendian));
    }
  }
  if (layout.time.is_there) set_point_times(times, cloud);
  return cloud;
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
  if (!reader.ok()) {
    return Error{ErrorCode::kMalformedPose, "a NavSatFix that is short", file};
  }
  if (status < 0) return std::optional<GeodeticFix>();
  const bool is_on_earth = std::abs(fix.at.latitude_deg) <= 90.0 &&
                           std::abs(fix.at.longitude_deg) <= 360.0 &&
                           std::abs(fix.at.altitude_m) < 1e5;
  if (is_on_earth) return std::optional<GeodeticFix>(fix);
  return Error{ErrorCode::kMalformedPose, "a NavSatFix that is no place on Earth", file};
}

// sensor_msgs, msg/Imu.msg: orientation, angular velocity and acceleration, each before its
// covariance of nine numbers.
std::optional<ImuMessage> parse_imu_message(std::span<const std::byte> message,
                                            MessageEncoding encoding) {
  constexpr double kFastest_radps = 100.0;
  constexpr int kOrientation = 4 + 9;
  constexpr int kRestOfMessage = 8 + 3 + 9;  // of the covariance, then the acceleration
  MessageReader reader(message, encoding);
  ImuMessage imu;
  imu.header = reader.header();
  for (int i = 0; i < kOrientation; ++i) reader.get<double>();
  for (double& rate : imu.rate_rad_per_s) rate = reader.get<double>();
  const auto covariance = reader.get<double>();
  for (int i = 0; i < kRestOfMessage; ++i) reader.get<double>();
  const bool is_rate = imu.rate_rad_per_s.norm() < kFastest_radps;  // not of what is not a number
  if (!reader.ok() || !is_rate || covariance == -1.0) return std::nullopt;
  return imu;
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
  return Error{ErrorCode::kMalformedPose, "a message of transforms that is short", file};
}

}  // namespace sightline

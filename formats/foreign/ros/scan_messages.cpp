#include "formats/foreign/ros/scan_messages.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "formats/base/units.h"
#include "formats/foreign/clouds/element_type.h"
#include "formats/foreign/logs/velodyne_packet.h"
#include "formats/foreign/ros/ros_messages.h"
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
  TimeName time_name;
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
  if (layout.time_name.take(name)) layout.time = field;
}

// Some drivers leave row_step at 0, or fill in that of another width. Where the data is as long as
// the points need without padding, there is none.
void settle_row_step(CloudLayout& layout) {
  const std::uint64_t row = layout.width * layout.point_step;
  const bool has_one_row = layout.height == 1 && row <= layout.data_size;
  if (has_one_row || layout.height * row == layout.data_size) layout.row_step = row;
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
  settle_row_step(layout);
  return layout;
}

Result<void> check_layout(const CloudLayout& layout, const FileBytes& file) {
  const auto& [x, y, z] = layout.position;
  if (layout.width == 0 || layout.height == 0) {
    return file.error(ErrorCode::kEmptyScan, "the message has a count of 0 points", at_byte(0));
  }
  if (!x.is_there || !y.is_there || !z.is_there) {
    return file.error(ErrorCode::kMissingField, "no fields x, y and z", at_byte(0));
  }
  for (const CloudField& field : {x, y, z, layout.intensity, layout.time}) {
    if (field.offset + field.type.size <= layout.point_step || !field.is_there) continue;
    return file.error(ErrorCode::kMalformedHeader, "a field is outside its point", at_byte(0));
  }
  if (layout.row_step < layout.width * layout.point_step) {
    return file.error(ErrorCode::kMalformedHeader, "a row is shorter than its points", at_byte(0));
  }
  const std::uint64_t left = file.bytes.size() - layout.data_offset;
  if (layout.data_size > left || layout.height > layout.data_size / layout.row_step) {
    return file.error(
        ErrorCode::kTruncatedScan,
        concat("found ", std::min(left, layout.data_size), " bytes of points, expected ",
               layout.height, " rows of ", layout.row_step),
        at_byte(layout.data_offset));
  }
  return {};
}

double read_field(const std::uint8_t* point, const CloudField& field, bool is_bigendian) {
  if (!field.is_there) return 0.0;
  return is_bigendian ? read_big_endian_element(point + field.offset, field.type)
                      : read_element(point + field.offset, field.type);
}

constexpr std::string_view kVelodyneScan = "velodyne_msgs/VelodyneScan";

bool is_livox(std::string_view datatype) {
  return datatype == "livox_ros_driver2/CustomMsg" || datatype == "livox_ros_driver/CustomMsg";
}

// livox_ros_driver2, msg/CustomMsg.msg and CustomPoint.msg: times in ns after `timebase`.
Result<PointCloudFile> parse_livox(const FileBytes& file, MessageEncoding encoding) {
  constexpr std::size_t kPointSize = 19;  // in CDR a byte of padding follows
  MessageReader reader(file.bytes, encoding);
  reader.header();
  reader.get<std::uint64_t>();  // timebase; the header's stamp says the same
  reader.get<std::uint32_t>();  // points, counted once more
  reader.take(4);               // number of the LiDAR, reserved
  const std::uint32_t count = reader.count(kPointSize);
  PointCloudFile cloud;
  std::vector<double> times;
  for (std::uint32_t i = 0; reader.ok() && i < count; ++i) {
    const auto time_ns = reader.get<std::uint32_t>();
    const auto x_m = reader.get<float>();
    const auto y_m = reader.get<float>();
    const auto z_m = reader.get<float>();
    const auto reflectivity = reader.get<std::uint8_t>();
    reader.take(2);  // tag, line
    const Eigen::Vector3d point_m(x_m, y_m, z_m);
    if (reader.ok() && add_point(cloud, point_m, reflectivity)) times.push_back(time_ns);
  }
  if (!reader.ok()) {
    return file.error(ErrorCode::kTruncatedScan,
                      concat("the message ends within its ", count, " points"),
                      at_byte(reader.offset()));
  }
  if (count == 0) {
    return file.error(ErrorCode::kEmptyScan, "the message has a count of 0 points", at_byte(0));
  }
  set_point_times(times, cloud, /*known_unit_ns=*/1.0);
  return cloud;
}

Result<void> check_packet(const VelodynePacket& packet, const FileBytes& file, std::size_t offset) {
  if (!packet.is_valid()) {
    return file.error(ErrorCode::kMalformedHeader,
                      "found 1206 bytes that are not a Velodyne data packet", at_byte(offset));
  }
  if (packet.model()) return {};
  return file.error(
      ErrorCode::kUnsupportedFormat,
      concat("found packets of product id ", packet.product_id(),
             ", expected those of an HDL-32E (33) or VLP-16 (34); record the driver's "
             "sensor_msgs/PointCloud2"),
      at_byte(offset));
}

// velodyne_msgs, msg/VelodyneScan.msg and VelodynePacket.msg.
Result<PointCloudFile> parse_velodyne(const FileBytes& file, MessageEncoding encoding) {
  constexpr std::int64_t kLongestScan_ns = 2 * kSecond_ns;
  constexpr std::size_t kStampSize = 8;
  MessageReader reader(file.bytes, encoding);
  reader.header();
  const std::uint32_t count = reader.count(kStampSize + kVelodynePacketSize);
  PointCloudFile cloud;
  for (std::uint32_t i = 0; reader.ok() && i < count; ++i) {
    const std::int64_t time_ns = reader.time_ns();
    const std::size_t offset = reader.offset();
    const std::span<const std::byte> bytes = reader.take(kVelodynePacketSize);
    if (!reader.ok()) break;
    const VelodynePacket packet(bytes);
    SIGHTLINE_TRY(check_packet(packet, file, offset));
    if (!cloud.time_origin_ns) cloud.time_origin_ns = time_ns;
    const std::int64_t after_ns = time_ns - *cloud.time_origin_ns;
    if (after_ns < -kLongestScan_ns || after_ns > kLongestScan_ns) {
      return file.error(ErrorCode::kMalformedHeader, "packets of one scan are more than 2 s apart",
                        at_byte(offset));
    }
    for (std::size_t block = 0; block < kVelodyneBlocks; ++block) {
      packet.append_block(block, after_ns, cloud);
    }
  }
  if (!reader.ok()) {
    return file.error(ErrorCode::kTruncatedScan, "the message ends within its packets",
                      at_byte(reader.offset()));
  }
  if (count > 0) return cloud;
  return file.error(ErrorCode::kEmptyScan, "the message contains no packets", at_byte(0));
}

}  // namespace

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
  layout.time_name.set_times(times, cloud);
  return cloud;
}

bool is_scan_message(std::string_view datatype) {
  return datatype == kPointCloud2 || datatype == kVelodyneScan || is_livox(datatype);
}

Result<PointCloudFile> parse_scan_message(std::span<const std::byte> message,
                                          std::string_view datatype, const std::string& name,
                                          MessageEncoding encoding) {
  const FileBytes file{message, name};
  if (is_livox(datatype)) return parse_livox(file, encoding);
  if (datatype == kVelodyneScan) return parse_velodyne(file, encoding);
  return parse_point_cloud2(message, name, encoding);
}

}  // namespace sightline

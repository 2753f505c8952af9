#include "formats/foreign/ros/scan_messages.h"

#include <vector>

#include "formats/base/units.h"
#include "formats/foreign/clouds/points/add_point.h"
#include "formats/foreign/clouds/points/point_cloud_file.h"
#include "formats/foreign/clouds/points/point_times.h"
#include "formats/foreign/logs/velodyne_packet.h"
#include "formats/foreign/ros/message_reader.h"
#include "formats/foreign/ros/ros_messages.h"
#include "formats/foreign/text/file_bytes.h"

namespace sightline {
namespace {

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
                      "the message ends within its " + std::to_string(count) + " points",
                      at_byte(reader.offset()));
  }
  if (count == 0) {
    return file.error(ErrorCode::kEmptyScan, "the message says that there are no points",
                      at_byte(0));
  }
  set_point_times(times, cloud, /*known_unit_ns=*/1.0);
  return cloud;
}

Result<void> check_packet(const VelodynePacket& packet, const FileBytes& file, std::size_t offset) {
  if (!packet.is_valid()) {
    return file.error(ErrorCode::kMalformedHeader,
                      "found 1206 bytes that are no Velodyne data packet", at_byte(offset));
  }
  if (packet.model()) return {};
  return file.error(ErrorCode::kUnsupportedFormat,
                    "found packets of product id " + std::to_string(packet.product_id()) +
                        ", expected those of an HDL-32E (33) or VLP-16 (34); record the driver's "
                        "sensor_msgs/PointCloud2",
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
      return file.error(ErrorCode::kMalformedHeader, "packets of one scan more than 2 s apart",
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
  return file.error(ErrorCode::kEmptyScan, "the message holds no packets", at_byte(0));
}

}  // namespace

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

#include "formats/foreign/ros/scan_messages.h"

#include "tests/formats/foreign/bag_files.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

constexpr const char* kLivox = "livox_ros_driver/CustomMsg";
constexpr const char* kVelodyne = "velodyne_msgs/VelodyneScan";

Result<PointCloudFile> parse_ros1(const std::string& message, const char* type) {
  return parse_scan_message(std::as_bytes(std::span(message)), type, "m", MessageEncoding::kRos1);
}

// Points of 19 bytes without gaps, 10 ms apart.
std::string livox(std::uint32_t points) {
  std::string bytes = ros_header(7, 5) + as_bytes({std::uint64_t{7}}) + as_bytes({points});
  bytes += std::string(4, '\1') + as_bytes({points});
  for (std::uint32_t i = 0; i < points; ++i) {
    const auto x_m = static_cast<float>(i + 1);
    bytes += as_bytes({10'000'000 * i}) + as_bytes({x_m, 2.0F, 3.0F}) + "\x09\x10\x01";
  }
  return bytes;
}

std::string velodyne_packet(char product) {
  std::string bytes;
  for (std::uint16_t block = 0; block < 12; ++block) {
    bytes += "\xff\xee" + as_bytes({static_cast<std::uint16_t>(40 * block)});
    for (int i = 0; i < 32; ++i) bytes += as_bytes({std::uint16_t{5000}}) + '\7';
  }
  return bytes + as_bytes({1000U}) + '\x37' + product;
}

std::string velodyne(std::uint32_t second_packet_s, char product) {
  return ros_header(7, 0) + as_bytes({2U}) + as_bytes({7U, 0U}) + velodyne_packet(product) +
         as_bytes({second_packet_s, 0U}) + velodyne_packet(product);
}

TEST(LivoxMessage, OfRos1IsReadAndRefusedWhereverItIsCut) {
  const std::string message = livox(3);
  const PointCloudFile cloud = value_of(parse_ros1(message, kLivox));
  EXPECT_EQ(cloud.points_m.at(2), Eigen::Vector3d(3, 2, 3));
  EXPECT_EQ(cloud.intensity.at(2), 9.0F);
  EXPECT_EQ(cloud.time_offset_ns, (std::vector<std::int32_t>{0, 10'000'000, 20'000'000}));
  for (std::size_t size = 0; size < message.size(); ++size) {
    EXPECT_FALSE(parse_ros1(message.substr(0, size), kLivox).has_value()) << size;
  }
  EXPECT_EQ(parse_ros1(livox(0), kLivox).error().code, ErrorCode::kEmptyScan);
}

TEST(VelodyneScanMessage, IsReadPacketByPacketAndRefusedWhereItIsNone) {
  const std::string message = velodyne(7, '\x22');
  const PointCloudFile cloud = value_of(parse_ros1(message, kVelodyne));
  EXPECT_EQ(cloud.points_m.size(), 2U * 12U * 32U);
  EXPECT_EQ(cloud.time_origin_ns, 7'000'000'000);
  EXPECT_FALSE(parse_ros1(message.substr(0, message.size() - 1), kVelodyne).has_value());
  EXPECT_EQ(parse_ros1(velodyne(7, '\x28'), kVelodyne).error().code, ErrorCode::kUnsupportedFormat);
  EXPECT_EQ(parse_ros1(velodyne(10, '\x22'), kVelodyne).error().code, ErrorCode::kMalformedHeader);
  std::string damaged = message;
  damaged[message.size() - 1206] = 'x';
  EXPECT_EQ(parse_ros1(damaged, kVelodyne).error().code, ErrorCode::kMalformedHeader);
}

}  // namespace
}  // namespace sightline

#include "formats/foreign/ros_bag.h"

#include <rosbag/bag.h>

#include "formats/foreign/recording.h"
#include "formats/foreign/ros_messages.h"
#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

// A message that was serialized already.
struct Serialized {
  std::string bytes;
};

}  // namespace
}  // namespace sightline

// What the library asks of a message type.
namespace ros {
namespace message_traits {
template <>
struct MD5Sum<sightline::Serialized> {
  static const char* value(const sightline::Serialized&) { return "*"; }
};
template <>
struct DataType<sightline::Serialized> {
  static const char* value(const sightline::Serialized&) { return "*"; }
};
template <>
struct Definition<sightline::Serialized> {
  static const char* value(const sightline::Serialized&) { return ""; }
};
}  // namespace message_traits
namespace serialization {
template <>
struct Serializer<sightline::Serialized> {
  template <class Stream>
  static void write(Stream& stream, const sightline::Serialized& message) {
    std::memcpy(stream.advance(static_cast<std::uint32_t>(message.bytes.size())),
                message.bytes.data(), message.bytes.size());
  }
  static std::uint32_t serializedLength(const sightline::Serialized& message) {
    return static_cast<std::uint32_t>(message.bytes.size());
  }
};
}  // namespace serialization
}  // namespace ros

namespace sightline {
namespace {

constexpr std::uint32_t kFirst_s = 1'567'410'201;

std::string text(std::string_view word) {
  return as_bytes({static_cast<std::uint32_t>(word.size())}) + std::string(word);
}

std::string header(std::uint32_t seconds, std::uint32_t nanoseconds) {
  return as_bytes({std::uint32_t{0}, seconds, nanoseconds}) + text("lidar");
}

struct Field {
  std::string_view name;
  std::uint32_t offset;
  std::uint8_t type;  // as sensor_msgs/PointField numbers them
};

// `data` holds rows of `width` points of `step` bytes and `padding` bytes each.
std::string cloud_message(std::uint32_t nanoseconds, const std::vector<Field>& fields,
                          std::uint32_t width, std::uint32_t step, const std::string& data,
                          std::uint32_t padding = 0, bool is_bigendian = false) {
  const std::uint32_t row = width * step + padding;
  const auto height = static_cast<std::uint32_t>(data.size() / row);
  std::string bytes = header(kFirst_s, nanoseconds);
  bytes += as_bytes({height, width, static_cast<std::uint32_t>(fields.size())});
  for (const Field& field : fields) {
    bytes += text(field.name) + as_bytes({field.offset}) + as_bytes({field.type});
    bytes += as_bytes({std::uint32_t{1}});
  }
  bytes += static_cast<char>(is_bigendian ? 1 : 0);
  bytes += as_bytes({step, row}) + text(data) + '\1';
  return bytes;
}

const std::vector<Field> kXyzit = {
    {"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"intensity", 12, 7}, {"t", 16, 6}};

// Two points 50 ms apart, as Ouster's driver writes them.
std::string ouster_message(std::uint32_t nanoseconds, float x_m) {
  return cloud_message(nanoseconds, kXyzit, 2, 20,
                       as_bytes({x_m, 2.0F, 3.0F, 9.0F}) + as_bytes({std::uint32_t{0}}) +
                           as_bytes({x_m, 5.0F, 6.0F, 8.0F}) + as_bytes({50'000'000U}));
}

std::string odometry_message(std::uint32_t nanoseconds, double x_m) {
  return header(kFirst_s, nanoseconds) + text("base_link") +
         as_bytes({x_m, 2.0, 3.0, 0.0, 0.0, 1.0, 0.0}) +
         std::string(36 * 8 + 12 * 8 + 36 * 8, '\0');
}

class RosBag : public testing::Test {
 protected:
  struct Message {
    std::string topic;
    std::string type;
    std::uint32_t nanoseconds;
    std::string bytes;
  };
  std::string write(
      const std::vector<Message>& messages,
      rosbag::compression::CompressionType compression = rosbag::compression::Uncompressed) {
    const std::string path = (folder_ / "drive.bag").string();
    rosbag::Bag bag(path, rosbag::bagmode::Write);
    bag.setCompression(compression);
    bag.setChunkThreshold(100);  // several chunks
    for (const Message& message : messages) {
      auto connection = boost::make_shared<ros::M_string>();
      (*connection)["type"] = message.type;
      (*connection)["md5sum"] = "0123456789abcdef0123456789abcdef";
      (*connection)["message_definition"] = "";
      (*connection)["topic"] = message.topic;
      bag.write(message.topic, ros::Time(kFirst_s, message.nanoseconds), Serialized{message.bytes},
                connection);
    }
    bag.close();
    return path;
  }
  std::vector<Message> drive() {
    std::vector<Message> messages;
    for (std::uint32_t i = 0; i < 5; ++i) {
      const std::uint32_t now_ns = 100'000'000 * i;
      messages.push_back({"/points", std::string(kPointCloud2), now_ns,
                          ouster_message(now_ns, 1.0F + static_cast<float>(i))});
      messages.push_back(
          {"/odom", "nav_msgs/Odometry", now_ns, odometry_message(now_ns + 50'000'000, i)});
    }
    return messages;
  }

  ScratchFolder folder_;
};

TEST_F(RosBag, IsADriveWithTimesAndPosesWhateverItsCompression) {
  using namespace rosbag::compression;
  for (const CompressionType compression : {Uncompressed, BZ2, LZ4}) {
    RecordingOptions options;
    options.scans = write(drive(), compression);
    options.poses = options.scans;
    const Result<Recording> recording = open_recording(options);
    ASSERT_TRUE(recording.has_value()) << to_string(recording.error());
    ASSERT_EQ(recording->scans.size(), 5U);
    EXPECT_EQ(recording->scans[3].name, "drive.bag#3");
    EXPECT_EQ(recording->scans[3].stamp_ns, 1'567'410'201'300'000'000);
    // Odometry begins 50 ms later: the first scan has no pose, the others lie between two.
    EXPECT_FALSE(recording->scans[0].T_world_vehicle.has_value());
    ASSERT_TRUE(recording->scans[3].T_world_vehicle.has_value());
    EXPECT_NEAR(recording->scans[3].T_world_vehicle->translation().x(), 2.5, 1e-12);
    EXPECT_NEAR((*recording->scans[3].T_world_vehicle)(0, 0), -1.0, 1e-12);
    ASSERT_EQ(recording->warnings.size(), 1U);
    EXPECT_NE(recording->warnings[0].find("1 of 5 scans have no poses"), std::string::npos);

    const Result<Scan> scan = recorded_scan_store(*recording)->read(3);
    ASSERT_TRUE(scan.has_value()) << to_string(scan.error());
    EXPECT_EQ(scan->points_m,
              (std::vector<Eigen::Vector3d>{Eigen::Vector3d(4, 2, 3), Eigen::Vector3d(4, 5, 6)}));
    EXPECT_EQ(scan->time_offset_ns, (std::vector<std::int32_t>{0, 50'000'000}));
  }
}

TEST_F(RosBag, NamesItsTopicsWhereTheChoiceIsNotClear) {
  std::vector<RosBag::Message> messages = drive();
  messages.push_back({"/other", std::string(kPointCloud2), 900, ouster_message(900, 1.0F)});
  RecordingOptions options;
  options.scans = write(messages);
  EXPECT_EQ(open_recording(options).error().code, ErrorCode::kBadValue);
  EXPECT_NE(open_recording(options).error().message.find("/other"), std::string::npos);
  options.topic = "/points";
  EXPECT_EQ(open_recording(options)->scans.size(), 5U);
  options.topic = "/odom";
  EXPECT_EQ(open_recording(options).error().code, ErrorCode::kUnknownName);
  options.scans = write({drive()[1]});
  options.topic = "";
  EXPECT_EQ(open_recording(options).error().code, ErrorCode::kUnsupportedFormat);
  options.scans = folder_.path().string();
  options.topic = "/points";
  EXPECT_EQ(open_recording(options).error().code, ErrorCode::kBadValue);
}

TEST_F(RosBag, IsRefusedWhenCutAnywhereAndNeverCrashes) {
  const std::string path = write(drive());
  const Result<std::string> whole = read_text_file(path);
  ASSERT_TRUE(whole.has_value());
  RecordingOptions options;
  options.scans = path;
  for (std::size_t size = 8; size < whole->size(); size += 37) {
    folder_.write("drive.bag", whole->substr(0, size));
    const Result<Recording> recording = open_recording(options);
    EXPECT_FALSE(recording.has_value()) << "cut at byte " << size;
  }
}

TEST(PointCloud2, ReadsTypesByteOrdersAndPaddedRows) {
  const std::vector<Field> fields = {{"ring", 0, 4}, {"z", 2, 3}, {"x", 4, 8}, {"y", 12, 5}};
  const auto point = [](double x, std::int32_t y, std::int16_t z) {
    return as_bytes({std::uint16_t{3}}) + as_bytes({z}) + as_bytes({x}) + as_bytes({y});
  };
  const std::string row = point(1e-3, -2, 3) + point(4.5, 5, -6) + "pad";
  const std::string message = cloud_message(0, fields, 2, 16, row + row, 3);
  const std::span<const std::byte> bytes = std::as_bytes(std::span(message));
  const Result<PointCloudFile> cloud = parse_point_cloud2(bytes, "m");
  ASSERT_TRUE(cloud.has_value()) << to_string(cloud.error());
  ASSERT_EQ(cloud->points_m.size(), 4U);
  EXPECT_EQ(cloud->points_m[0], Eigen::Vector3d(1e-3, -2, 3));
  EXPECT_EQ(cloud->points_m[3], Eigen::Vector3d(4.5, 5, -6));
  // Every shorter message is refused, wherever it is cut; but for is_dense at its end.
  for (std::size_t size = 0; size + 1 < message.size(); ++size) {
    EXPECT_FALSE(parse_point_cloud2(bytes.first(size), "m").has_value()) << size;
  }
  std::string turned;
  for (const float value : {1.5F, -2.0F, 3.0F}) {
    const std::string little = as_bytes({value});
    turned.append(little.rbegin(), little.rend());
  }
  const std::string big = cloud_message(0, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}}, 1, 12, turned,
                                        0, /*is_bigendian=*/true);
  EXPECT_EQ(parse_point_cloud2(std::as_bytes(std::span(big)), "m")->points_m.at(0),
            Eigen::Vector3d(1.5, -2.0, 3.0));
}

TEST(PointCloud2, RefusesWhatContradictsItself) {
  const auto code = [](const std::string& message) {
    const Result<PointCloudFile> cloud = parse_point_cloud2(std::as_bytes(std::span(message)), "m");
    return cloud ? ErrorCode{} : cloud.error().code;
  };
  const std::string point = as_bytes({1.0F, 2.0F, 3.0F});
  const std::vector<Field> xyz = {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}};
  EXPECT_EQ(code(cloud_message(0, {{"x", 0, 7}, {"y", 4, 7}}, 1, 12, point)),
            ErrorCode::kMissingField);
  EXPECT_EQ(code(cloud_message(0, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 8}}, 1, 12, point)),
            ErrorCode::kMalformedHeader);
  EXPECT_EQ(code(cloud_message(0, xyz, 1, 12, "")), ErrorCode::kEmptyScan);
  EXPECT_EQ(code(cloud_message(0, {{"x", 0, 99}, {"y", 4, 7}, {"z", 8, 7}}, 1, 12, point)),
            ErrorCode::kMissingField);
}

TEST(PoseMessage, IsReadFromEachTypeAndRefusedWhenItIsNone) {
  const std::string numbers = as_bytes({1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0});
  for (const char* type :
       {"nav_msgs/Odometry", "geometry_msgs/TransformStamped", "geometry_msgs/PoseStamped",
        "geometry_msgs/PoseWithCovarianceStamped"}) {
    ASSERT_TRUE(is_pose_message(type));
    const std::string_view name = type;
    const bool names_a_child = name.find("Odom") != name.npos || name.find("Trans") != name.npos;
    const std::string message = header(7, 5) + (names_a_child ? text("child") : "") + numbers;
    const std::span<const std::byte> bytes = std::as_bytes(std::span(message));
    const Result<PoseRow> row = parse_pose_message(bytes, type, "m");
    ASSERT_TRUE(row.has_value()) << to_string(row.error());
    EXPECT_EQ(row->stamp_ns, 7'000'000'005);
    EXPECT_EQ(row->T_world_vehicle.translation(), Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(parse_pose_message(bytes.first(bytes.size() - 1), type, "m").error().code,
              ErrorCode::kMalformedPose);
  }
  const std::string no_rotation = header(7, 5) + as_bytes({1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 2.0});
  EXPECT_EQ(
      parse_pose_message(std::as_bytes(std::span(no_rotation)), "geometry_msgs/PoseStamped", "m")
          .error()
          .code,
      ErrorCode::kNotARotation);
  EXPECT_FALSE(is_pose_message("sensor_msgs/Imu"));
}

}  // namespace
}  // namespace sightline

#include "formats/foreign/ros/ros_bag.h"

#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/ros/ros_messages.h"
#include "formats/foreign/ros/scan_messages.h"
#include "tests/formats/foreign/bag_files.h"

namespace sightline {
namespace {

using enum ErrorCode;
constexpr std::uint32_t kFirst_s = 1'567'410'201;

const std::vector<BagField> kXyzit = {
    {"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"intensity", 12, 7}, {"t", 16, 6}};

// Two points 50 ms apart, as Ouster's driver writes them.
std::string ouster_message(std::uint32_t nanoseconds, float x_m) {
  return cloud_message(kFirst_s, nanoseconds, kXyzit, 2, 20,
                       as_bytes({x_m, 2.0F, 3.0F, 9.0F}) + as_bytes({std::uint32_t{0}}) +
                           as_bytes({x_m, 5.0F, 6.0F, 8.0F}) + as_bytes({50'000'000U}));
}

std::string odometry_message(std::uint32_t nanoseconds, double x_m) {
  return ros_header(kFirst_s, nanoseconds) + ros_text("base_link") +
         as_bytes({x_m, 2.0, 3.0, 0.0, 0.0, 1.0, 0.0}) +
         std::string(36 * 8 + 12 * 8 + 36 * 8, '\0');
}

class RosBag : public testing::Test {
 protected:
  std::string write(
      const std::vector<BagMessage>& messages,
      rosbag::compression::CompressionType compression = rosbag::compression::Uncompressed) {
    write_bag(folder_ / "drive.bag", messages, compression);
    return (folder_ / "drive.bag").string();
  }
  std::vector<BagMessage> drive() {
    std::vector<BagMessage> messages;
    for (std::uint32_t i = 0; i < 5; ++i) {
      const std::uint32_t now_ns = 100'000'000 * i;
      messages.push_back({"/points", std::string(kPointCloud2), kFirst_s, now_ns,
                          ouster_message(now_ns, 1.0F + static_cast<float>(i))});
      messages.push_back({"/odom", "nav_msgs/Odometry", kFirst_s, now_ns,
                          odometry_message(now_ns + 50'000'000, i)});
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
    const Recording recording = value_of(open_recording(options));
    // Odometry begins 50 ms later: the first scan has no pose, the others lie between two.
    ASSERT_EQ(recording.scans.size(), 4U);
    EXPECT_EQ(recording.scans[2].name, "drive.bag#3");
    EXPECT_EQ(recording.scans[2].index, 3U);
    EXPECT_EQ(recording.scans[2].stamp_ns, 1'567'410'201'300'000'000);
    ASSERT_TRUE(recording.scans[2].T_world_vehicle.has_value());
    EXPECT_NEAR(recording.scans[2].T_world_vehicle->translation().x(), 2.5, 1e-12);
    EXPECT_NEAR((*recording.scans[2].T_world_vehicle)(0, 0), -1.0, 1e-12);
    ASSERT_EQ(recording.warnings.size(), 1U);
    EXPECT_THAT(recording.warnings[0], HasSubstr("1 of 5 scans have no pose: 1 before the first"));

    const Scan scan = value_of(recorded_scan_store(recording)->read(2));
    EXPECT_EQ(scan.points_m,
              (std::vector<Eigen::Vector3d>{Eigen::Vector3d(4, 2, 3), Eigen::Vector3d(4, 5, 6)}));
    EXPECT_EQ(scan.time_offset_ns, (std::vector<std::int32_t>{0, 50'000'000}));
  }
}

TEST_F(RosBag, NamesItsTopicsWhereTheChoiceIsNotClear) {
  std::vector<BagMessage> messages = drive();
  messages.push_back(
      {"/other", std::string(kPointCloud2), kFirst_s, 900, ouster_message(900, 1.0F)});
  RecordingOptions options;
  options.scans = write(messages);
  EXPECT_EQ(open_recording(options).error().code, kBadValue);
  EXPECT_THAT(open_recording(options).error().message, HasSubstr("/other"));
  options.topic = "/points";
  EXPECT_EQ(open_recording(options)->scans.size(), 5U);
  options.topic = "/odom";
  EXPECT_EQ(open_recording(options).error().code, kUnknownName);
  options.scans = write({drive()[1]});
  options.topic = "";
  EXPECT_EQ(open_recording(options).error().code, kUnsupportedFormat);
  options.scans = folder_.path().string();
  options.topic = "/points";
  EXPECT_EQ(open_recording(options).error().code, kBadValue);
}

TEST_F(RosBag, IsRefusedWhenCutAnywhereAndNeverCrashes) {
  const std::string path = write(drive());
  const std::string whole = value_of(read_text_file(path));
  RecordingOptions options;
  options.scans = path;
  for (std::size_t size = 8; size < whole.size(); size += 37) {
    folder_.write("drive.bag", whole.substr(0, size));
    EXPECT_FALSE(open_recording(options).has_value()) << "cut at byte " << size;
  }
}

TEST(PointCloud2, ReadsTypesByteOrdersAndPaddedRows) {
  const std::vector<BagField> fields = {{"ring", 0, 4}, {"z", 2, 3}, {"x", 4, 8}, {"y", 12, 5}};
  const auto point = [](double x, std::int32_t y, std::int16_t z) {
    return as_bytes({std::uint16_t{3}}) + as_bytes({z}) + as_bytes({x}) + as_bytes({y});
  };
  const std::string row = point(1e-3, -2, 3) + point(4.5, 5, -6) + "pad";
  const std::string message = cloud_message(kFirst_s, 0, fields, 2, 16, row + row, 3);
  const std::span<const std::byte> bytes = std::as_bytes(std::span(message));
  const PointCloudFile cloud = value_of(parse_point_cloud2(bytes, "m"));
  ASSERT_EQ(cloud.points_m.size(), 4U);
  EXPECT_EQ(cloud.points_m[0], Eigen::Vector3d(1e-3, -2, 3));
  EXPECT_EQ(cloud.points_m[3], Eigen::Vector3d(4.5, 5, -6));
  // Every shorter message is refused, wherever it is cut; but for is_dense at its end.
  for (std::size_t size = 0; size + 1 < message.size(); ++size) {
    EXPECT_FALSE(parse_point_cloud2(bytes.first(size), "m").has_value()) << size;
  }
  std::string turned;
  for (const float value : {1.5F, -2.0F, 3.0F}) {
    const std::string little = as_bytes({value});
    turned.append(little.rbegin(), little.rend());
  }
  const std::string big = cloud_message(kFirst_s, 0, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}}, 1, 12,
                                        turned, 0, /*is_bigendian=*/true);
  EXPECT_EQ(parse_point_cloud2(std::as_bytes(std::span(big)), "m")->points_m.at(0),
            Eigen::Vector3d(1.5, -2.0, 3.0));
}

TEST(PointCloud2, RefusesWhatContradictsItself) {
  const auto code = [](const std::string& message) {
    return code_of(parse_point_cloud2(std::as_bytes(std::span(message)), "m"));
  };
  const std::string point = as_bytes({1.0F, 2.0F, 3.0F});
  const std::vector<BagField> xyz = {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}};
  EXPECT_EQ(code(cloud_message(kFirst_s, 0, {{"x", 0, 7}, {"y", 4, 7}}, 1, 12, point)),
            kMissingField);
  EXPECT_EQ(code(cloud_message(kFirst_s, 0, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 8}}, 1, 12, point)),
            kMalformedHeader);
  EXPECT_EQ(code(cloud_message(kFirst_s, 0, xyz, 1, 12, "")), kEmptyScan);
  EXPECT_EQ(
      code(cloud_message(kFirst_s, 0, {{"x", 0, 99}, {"y", 4, 7}, {"z", 8, 7}}, 1, 12, point)),
      kMissingField);
}

// velodyne's driver for ROS 2 left row_step at 0 for years.
TEST(PointCloud2, NeedsNoRowStepWhereTheDataIsAsLongAsItsPoints) {
  const std::vector<BagField> xyz = {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}};
  const std::string row = as_bytes({1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F});
  for (const std::string& data : {row, row + row}) {
    std::string message = cloud_message(kFirst_s, 0, xyz, 2, 12, data);
    const std::size_t at = message.size() - 1 - data.size() - 8;  // of row_step
    for (const std::uint32_t row_step : {0U, 12U, 48U, 1U << 31U}) {
      message.replace(at, 4, as_bytes({row_step}));
      const Result<PointCloudFile> cloud =
          parse_point_cloud2(std::as_bytes(std::span(message)), "m");
      ASSERT_TRUE(cloud.has_value()) << row_step << " " << to_string(cloud.error());
      EXPECT_EQ(cloud->points_m.back(), Eigen::Vector3d(4, 5, 6));
      EXPECT_EQ(cloud->points_m.size(), data.size() / 12);
    }
  }
  std::string padded = cloud_message(kFirst_s, 0, xyz, 2, 12, row + "pad" + row + "pad", 3);
  padded.replace(padded.size() - 1 - 54 - 8, 4, as_bytes({0U}));
  EXPECT_EQ(code_of(parse_point_cloud2(std::as_bytes(std::span(padded)), "m")), kMalformedHeader);
}

TEST(PointCloud2, ReadsTheTimesOfAutowareAndNamesAnUnknownField) {
  const auto cloud_of = [](std::string_view name) {
    const std::string data = as_bytes({1.0F, 2.0F, 3.0F}) + as_bytes({0U}) +
                             as_bytes({4.0F, 5.0F, 6.0F}) + as_bytes({50'000'000U});
    const std::string message = cloud_message(
        kFirst_s, 0, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {name, 12, 6}}, 2, 16, data);
    return value_of(parse_point_cloud2(std::as_bytes(std::span(message)), "m"));
  };
  for (const char* name : {"time_stamp", "timestamp_ns", "GpsTime", "timeStamp", "t_ns"}) {
    EXPECT_EQ(cloud_of(name).time_offset_ns, (std::vector<std::int32_t>{0, 50'000'000})) << name;
    EXPECT_EQ(cloud_of(name).unread_time, "") << name;
  }
  EXPECT_TRUE(cloud_of("stamp_of_point").time_offset_ns.empty());
  EXPECT_EQ(cloud_of("stamp_of_point").unread_time, "stamp_of_point");
  EXPECT_EQ(cloud_of("ring").unread_time, "");
}

TEST(PoseMessage, IsReadFromEachTypeAndRefusedWhenItIsNone) {
  const std::string numbers = as_bytes({1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0});
  for (const char* type :
       {"nav_msgs/Odometry", "geometry_msgs/TransformStamped", "geometry_msgs/PoseStamped",
        "geometry_msgs/PoseWithCovarianceStamped"}) {
    ASSERT_TRUE(is_pose_message(type));
    const std::string_view name = type;
    const bool names_a_child = name.find("Odom") != name.npos || name.find("Trans") != name.npos;
    const std::string message =
        ros_header(7, 5) + (names_a_child ? ros_text("child") : "") + numbers;
    const std::span<const std::byte> bytes = std::as_bytes(std::span(message));
    const PoseRow row = value_of(parse_pose_message(bytes, type, "m"));
    EXPECT_EQ(row.stamp_ns, 7'000'000'005);
    EXPECT_EQ(row.T_world_vehicle.translation(), Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(parse_pose_message(bytes.first(bytes.size() - 1), type, "m").error().code,
              kMalformedPose);
  }
  const std::string no_rotation = ros_header(7, 5) + as_bytes({1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 2.0});
  EXPECT_EQ(code_of(parse_pose_message(std::as_bytes(std::span(no_rotation)),
                                       "geometry_msgs/PoseStamped", "m")),
            kNotARotation);
  EXPECT_FALSE(is_pose_message("sensor_msgs/Imu"));
}

}  // namespace
}  // namespace sightline

#include "formats/foreign/recording/open_recording.h"

#include "formats/foreign/ros/files/open_message_log.h"
#include "formats/foreign/ros/ros_bag.h"
#include "formats/foreign/ros/scan_messages.h"
#include "tests/formats/foreign/ros/ros2_recordings.h"
#include "tests/support/value_of.h"

// Recordings of ROS 2 by other writers (recordings/README.md), against what ROS 1 would give.

namespace sightline {
namespace {

class Ros2Drive : public testing::TestWithParam<const char*> {
 protected:
  Ros2Drive() { options_.scans = recording_path(GetParam()); }
  RecordingOptions options_;
};

PointCloudFile scan_by_ros1(std::uint32_t k) {
  std::string data;
  for (std::uint32_t n = 0; n < 6; ++n) {
    const auto i = static_cast<float>(n);
    const std::string point =
        as_bytes({static_cast<float>(k) + 1.0F + i, 2.0F - i, 0.5F * i, 10.0F * i}) +
        as_bytes({10'000'000 * n});
    data += point + std::string(4, '\0') + (n % 3 == 2 ? std::string(8, '\0') : "");
  }
  const std::vector<BagField> fields = {
      {"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"intensity", 12, 7}, {"t", 16, 6}};
  const std::string message = cloud_message(kFirst_s, 100'000'000 * k, fields, 3, 24, data, 8);
  return *parse_point_cloud2(std::as_bytes(std::span(message)), "ros1");
}

TEST_P(Ros2Drive, HasTheScansThatRos1Has) {
  const Recording recording = value_of(open_recording(options_));
  ASSERT_EQ(recording.scans.size(), 4U);
  EXPECT_TRUE(recording.warnings.empty()) << recording.warnings.front();
  for (std::uint32_t k = 0; k < 4; ++k) {
    EXPECT_EQ(recording.scans[k].stamp_ns, 1'000'000'000LL * kFirst_s + 100'000'000LL * k);
    EXPECT_EQ(recording.scans[k].name,
              std::filesystem::path(GetParam()).filename().string() + "#" + std::to_string(k));
    const PointCloudFile scan = value_of(read_recorded_scan(recording, k));
    const PointCloudFile expected = scan_by_ros1(k);
    EXPECT_EQ(scan.points_m, expected.points_m);
    EXPECT_EQ(scan.intensity, expected.intensity);
    EXPECT_EQ(scan.time_offset_ns, expected.time_offset_ns);
    EXPECT_EQ(scan.time_offset_ns.size(), 6U);
  }
}

TEST_P(Ros2Drive, ListsItsTopics) {
  const std::vector<BagTopic> topics = value_of(list_bag_topics(recording_path(GetParam())));
  std::string listed;
  for (const BagTopic& topic : topics) {
    listed += topic.name + " " + topic.type + " " + std::to_string(topic.message_count) + "\n";
  }
  EXPECT_EQ(listed,
            "/odom nav_msgs/Odometry 4\n"
            "/points sensor_msgs/PointCloud2 4\n"
            "/tf tf2_msgs/TFMessage 15\n"
            "/tf_static tf2_msgs/TFMessage 1\n");
}

TEST_P(Ros2Drive, HasPosesFromOdometry) {
  options_.poses = options_.scans;
  const Recording recording = value_of(open_recording(options_));
  // Odometry begins 50 ms later: the first scan has no pose, the others lie between two.
  ASSERT_EQ(recording.scans.size(), 3U);
  const RecordedScan& last = recording.scans[2];
  EXPECT_EQ(last.index, 3U);
  ASSERT_TRUE(last.T_world_vehicle.has_value());
  EXPECT_TRUE(last.T_world_vehicle->translation().isApprox(Eigen::Vector3d(2.5, 2.0, 3.0), 1e-12));
  EXPECT_NEAR((*last.T_world_vehicle)(0, 0), -1.0, 1e-12);
  EXPECT_EQ(recording.world_frame, "odom");
}

// map to odom turns left and moves 100 m, odom to base_link goes 10 m/s along x, the LiDAR sits 1 m
// before and 2 m above base_link and looks back.
TEST_P(Ros2Drive, HasPosesFromTransformsOfVehicleAndSensor) {
  options_.poses = options_.scans;
  options_.poses_topic = "/tf";
  const Recording vehicle = value_of(open_recording(options_));
  options_.poses_of = PosesOf::kSensor;
  const Recording sensor = value_of(open_recording(options_));
  for (std::size_t k = 0; k < 4; ++k) {
    ASSERT_TRUE(vehicle.scans[k].T_world_vehicle && sensor.scans[k].T_world_vehicle);
    const Pose& T_map_base = *vehicle.scans[k].T_world_vehicle;
    const Pose& T_map_lidar = *sensor.scans[k].T_world_vehicle;
    const auto along_m = static_cast<double>(k);
    EXPECT_TRUE(T_map_base.translation().isApprox(Eigen::Vector3d(100, along_m, 0), 1e-12));
    EXPECT_TRUE(T_map_lidar.translation().isApprox(Eigen::Vector3d(100, along_m + 1, 2), 1e-12));
    EXPECT_TRUE(
        (T_map_base.linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
    EXPECT_TRUE((T_map_lidar.linear() * Eigen::Vector3d::UnitX())
                    .isApprox(-Eigen::Vector3d::UnitY(), 1e-12));
  }
}

TEST_P(Ros2Drive, TellsTheMountingOfItsSensor) {
  const Result<std::optional<Pose>> mounting = bag_mounting(recording_path(GetParam()), "lidar");
  ASSERT_TRUE(mounting.has_value() && mounting->has_value());
  EXPECT_EQ((*mounting)->translation(), Eigen::Vector3d(1, 0, 2));
  EXPECT_NEAR((**mounting)(0, 0), -1.0, 1e-15);
  EXPECT_FALSE(bag_mounting(recording_path(GetParam()), "camera")->has_value());
}

INSTANTIATE_TEST_SUITE_P(EveryForm, Ros2Drive,
                         testing::Values("zstd.mcap", "lz4.mcap", "none.mcap", "without_index.mcap",
                                         "without_chunks.mcap", "drive.db3", "big_endian.db3",
                                         "packed"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::ranges::replace(name, '.', '_');
                           return name;
                         });

TEST(Ros2Sensors, AreRead) {
  const std::string path = recording_path("sensors.mcap");
  RecordingOptions options;
  options.scans = path;
  EXPECT_EQ(open_recording(options).error().code, ErrorCode::kBadValue);  // two topics
  options.topic = "/livox/lidar";
  const PointCloudFile scan = value_of(read_recorded_scan(value_of(open_recording(options)), 1));
  ASSERT_EQ(scan.points_m.size(), 3U);
  EXPECT_EQ(scan.points_m[2], Eigen::Vector3d(3, 4, 5));
  EXPECT_EQ(scan.intensity, (std::vector<float>{40, 41, 42}));
  EXPECT_EQ(scan.time_offset_ns, (std::vector<std::int32_t>{0, 5'000'000, 10'000'000}));
  options.topic = "/velodyne_packets";
  const Scan returns = value_of(recorded_scan_store(value_of(open_recording(options)))->read(1));
  ASSERT_EQ(returns.points_m.size(), 2U * 12U * 32U);
  // Laser 0 looks 15 degrees down at azimuth 0, 10 m away, from 11.2 mm above the centre.
  EXPECT_NEAR(returns.points_m[0].x(), 10.0 * std::cos(15.0 * M_PI / 180.0), 1e-9);
  EXPECT_NEAR(returns.points_m[0].y(), 0.0, 1e-12);
  EXPECT_NEAR(returns.points_m[0].z(), 0.0112 - 10.0 * std::sin(15.0 * M_PI / 180.0), 1e-9);
  // The stamp is that of the last packet, as the driver writes it.
  EXPECT_EQ(returns.time_offset_ns.front(), -1'327'000);
  EXPECT_EQ(returns.time_offset_ns[12 * 32], 0);
}

TEST(Ros2Poses, AreReadFromEachType) {
  const std::string path = recording_path("sensors.mcap");
  EXPECT_EQ(read_bag_poses(path, "").error().code, ErrorCode::kBadValue);
  EXPECT_EQ(read_bag_poses(path, "/fix").error().code, ErrorCode::kUnknownName);
  for (const char* topic : {"/pose", "/pose_with_covariance"}) {
    const std::vector<PoseRow> rows = value_of(read_bag_poses(path, topic));
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_EQ(rows[1].T_world_vehicle.translation(), Eigen::Vector3d(1, 2, 3));
    EXPECT_NEAR(rows[1].T_world_vehicle(0, 0), 0.28, 1e-12);
  }
}

TEST(Ros2Fixes, AreReadWhereTheyAreNamed) {
  const std::filesystem::path file = recording_path("sensors.mcap");
  const std::optional<GeodeticTrack> track = value_of(read_bag_fixes(file, "/fix"));
  ASSERT_TRUE(track.has_value());
  ASSERT_EQ(track->fixes.size(), 2U);
  EXPECT_EQ(track->fixes[1].at.latitude_deg, 49.0);
  EXPECT_EQ(track->fixes[1].at.longitude_deg, 8.4);
  EXPECT_EQ(track->fixes[1].at.altitude_m, 112.0);
  EXPECT_EQ(*track->fixes[1].stamp_ns - *track->fixes[0].stamp_ns, 100'000'000);
  EXPECT_FALSE(read_bag_fixes(file, "")->has_value()) << "there are poses";
  EXPECT_FALSE(read_bag_fixes(file, "/pose")->has_value());
  RecordingOptions options;
  options.scans = options.poses = file.string();
  options.topic = "/livox/lidar";
  options.poses_topic = "/fix";
  EXPECT_THAT(to_string(open_recording(options).error()), HasSubstr("no heading is given"));
}

}  // namespace
}  // namespace sightline

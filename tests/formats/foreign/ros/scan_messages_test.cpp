#include "formats/foreign/ros/scan_messages.h"

#include <gtest/gtest.h>

#include "formats/foreign/ros/bag_topics.h"
#include "formats/foreign/ros/ros_messages.h"
#include "tests/formats/foreign/bag_files.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using namespace std::string_literals;

MessageReader reader_of(const std::string& bytes,
                        MessageEncoding encoding = MessageEncoding::kCdr) {
  return MessageReader(std::as_bytes(std::span(bytes)), encoding);
}

TEST(MessageReader, AlignsBehindTheFirstFourBytes) {
  // A byte, 3 of padding, a 32-bit number, a byte, 7 of padding, a double.
  const std::string bytes = "\0\1\0\0"s + "\x05"s + "\0\0\0"s + as_bytes({7U}) + "\x06"s +
                            std::string(7, '\0') + as_bytes({1.5});
  MessageReader reader = reader_of(bytes);
  EXPECT_EQ(reader.get<std::uint8_t>(), 5);
  EXPECT_EQ(reader.get<std::uint32_t>(), 7U);
  EXPECT_EQ(reader.get<std::uint8_t>(), 6);
  EXPECT_EQ(reader.get<double>(), 1.5);
  EXPECT_TRUE(reader.ok());
  EXPECT_EQ(reader.remaining(), 0U);
  reader.get<std::uint8_t>();
  EXPECT_FALSE(reader.ok());
}

TEST(MessageReader, AlignsDoublesToFourInXcdr2) {
  const std::string bytes = "\0\7\0\0"s + as_bytes({7U}) + as_bytes({1.5});
  MessageReader reader = reader_of(bytes);
  EXPECT_EQ(reader.get<std::uint32_t>(), 7U);
  EXPECT_EQ(reader.get<double>(), 1.5);
  EXPECT_TRUE(reader.ok());
}

TEST(MessageReader, ReadsBothByteOrders) {
  const std::string bytes = "\0\0\0\0"s + "\0\0\1\2"s + "\0\0\0\3ab\0"s;
  MessageReader big = reader_of(bytes);
  EXPECT_EQ(big.get<std::uint32_t>(), 258U);
  EXPECT_EQ(big.text(), "ab");
  EXPECT_TRUE(big.ok());
}

TEST(MessageReader, RefusesOtherEncapsulationsAndLengthsThatAreNotThere) {
  EXPECT_FALSE(reader_of("\0\3\0\0"s).ok());  // a list of parameters
  EXPECT_FALSE(reader_of("\0\1\0"s).ok());
  const std::string long_text = "\0\1\0\0"s + as_bytes({0xffff'ffffU}) + "ab";
  MessageReader reader = reader_of(long_text);
  EXPECT_EQ(reader.text(), "");
  EXPECT_FALSE(reader.ok());
}

TEST(MessageReader, ReadsHeadersOfRos1AndRos2) {
  const std::string ros2 = "\0\1\0\0"s + as_bytes({7U, 5U, 6U}) + "lidar\0"s;
  EXPECT_EQ(reader_of(ros2).header().stamp_ns, 7'000'000'005);
  const std::string ros1 = as_bytes({9U, 7U, 5U, 6U}) + "/lidar"s;
  const MessageHeader header = reader_of(ros1, MessageEncoding::kRos1).header();
  EXPECT_EQ(header.stamp_ns, 7'000'000'005);
  EXPECT_EQ(header.frame, "lidar");
}

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

constexpr std::int64_t kTenth_ns = 100'000'000;

StampedTransform moved(std::int64_t stamp_ns, const std::string& parent, const std::string& child,
                       double x_m) {
  StampedTransform transform{stamp_ns, parent, child, Pose::Identity()};
  transform.T_parent_child.translation().x() = x_m;
  return transform;
}

TransformTree driving() {
  TransformTree tree;
  for (int i = 0; i <= 10; ++i) tree.add(moved(i * kTenth_ns, "odom", "base_link", i), false);
  tree.add(moved(0, "base_link", "lidar", 0.5), true);
  return tree;
}

TEST(TransformTree, ComposesAtTheFastestTransform) {
  TransformTree tree = driving();
  tree.add(moved(0, "map", "odom", 100.0), false);
  tree.add(moved(10 * kTenth_ns, "map", "odom", 110.0), false);
  const std::vector<PoseRow> rows = value_of(tree.poses_of("lidar", "drive.mcap"));
  ASSERT_EQ(rows.size(), 11U);
  EXPECT_EQ(rows[3].stamp_ns, 3 * kTenth_ns);
  EXPECT_NEAR(rows[3].T_world_vehicle.translation().x(), 103.0 + 3.0 + 0.5, 1e-12);
}

TEST(TransformTree, EndsAtTheMapThatLiesOnEarth) {
  TransformTree tree = driving();
  tree.add(moved(0, "map", "odom", 100.0), false);
  tree.add(moved(0, "earth", "map", 6e6), true);
  const std::vector<PoseRow> rows = value_of(tree.poses_of("base_link", "drive.mcap"));
  EXPECT_EQ(rows.front().T_world_vehicle.translation().x(), 100.0);
}

TEST(TransformTree, LeavesOutTimesThatATransformDoesNotCover) {
  TransformTree tree = driving();
  tree.add(moved(2 * kTenth_ns, "map", "odom", 100.0), false);
  tree.add(moved(5 * kTenth_ns, "map", "odom", 100.5), false);
  EXPECT_EQ(tree.poses_of("base_link", "drive.mcap")->size(), 4U);
  // Later ones are too far away to say what was between.
  tree.add(moved(50 * kTenth_ns, "map", "odom", 101.0), false);
  EXPECT_EQ(tree.poses_of("base_link", "drive.mcap")->size(), 4U);
}

// Lidar and camera on one vehicle, the camera said again and again as older drivers do.
TEST(TransformTree, KnowsHowTwoFramesOfOneBodyLieToEachOther) {
  TransformTree tree = driving();
  StampedTransform camera = moved(0, "base_link", "camera", 2.0);
  camera.T_parent_child.linear() = Eigen::Quaterniond(0, 0, 0, 1).toRotationMatrix();  // looks back
  for (int i = 0; i < 3; ++i) {
    camera.stamp_ns = i * kTenth_ns;
    tree.add(camera, false);
  }
  tree.add(moved(0, "camera", "lens", 0.25), true);
  const std::optional<Pose> T_lidar_lens = tree.fixed_between("lidar", "lens");
  ASSERT_TRUE(T_lidar_lens.has_value());
  EXPECT_TRUE(T_lidar_lens->translation().isApprox(Eigen::Vector3d(1.25, 0, 0), 1e-12));
  EXPECT_TRUE(T_lidar_lens->linear().isApprox(camera.T_parent_child.linear(), 1e-12));
  const std::optional<Pose> T_lens_lidar = tree.fixed_between("lens", "lidar");
  ASSERT_TRUE(T_lens_lidar.has_value());
  EXPECT_TRUE((*T_lens_lidar * *T_lidar_lens).isApprox(Pose::Identity(), 1e-12));
  EXPECT_TRUE(tree.fixed_between("base_link", "lidar").has_value());
  EXPECT_FALSE(tree.fixed_between("odom", "lidar").has_value()) << "it moves";
  EXPECT_FALSE(tree.fixed_between("lidar", "nobody").has_value());
  camera.stamp_ns = 3 * kTenth_ns;
  camera.T_parent_child.translation().x() = 2.1;
  tree.add(camera, false);
  EXPECT_FALSE(tree.fixed_between("lidar", "lens").has_value()) << "the camera moves";
  tree = driving();
  tree.add(moved(0, "a", "b", 1.0), true);
  tree.add(moved(0, "b", "a", 1.0), true);
  EXPECT_TRUE(tree.fixed_between("a", "b").has_value());
  EXPECT_FALSE(tree.fixed_between("a", "lidar").has_value()) << "a circle";
}

// static_transform_publisher of ROS 1 has no /tf_static: it repeats the mounting on /tf.
TEST(TransformTree, TakesATransformThatIsRepeatedUnchangedAsFixed) {
  TransformTree tree;
  for (int i = 0; i <= 10; ++i) {
    tree.add(moved(i * kTenth_ns, "odom", "base_link", i), false);
    tree.add(moved(i * kTenth_ns + 7, "base_link", "lidar", 0.5 + (i % 2) * 1e-7), false);
  }
  const std::optional<Pose> mounting = tree.fixed_pose("base_link", "lidar");
  ASSERT_TRUE(mounting.has_value());
  EXPECT_NEAR(mounting->translation().x(), 0.5, 1e-6);
  EXPECT_EQ(tree.poses_of("lidar", "drive.mcap")->size(), 11U) << "at the times of odometry";
  tree.add(moved(11 * kTenth_ns, "base_link", "lidar", 0.6), false);
  EXPECT_FALSE(tree.fixed_pose("base_link", "lidar").has_value()) << "it moves";
}

TEST(TransformTree, TakesAStaticTransformOnceHoweverOftenItIsSaid) {
  TransformTree tree = driving();
  tree.add(moved(3 * kTenth_ns, "base_link", "lidar", 0.75), true);
  EXPECT_EQ(tree.fixed_pose("base_link", "lidar")->translation().x(), 0.75);
  EXPECT_FALSE(tree.fixed_pose("odom", "lidar").has_value());  // it moves
  EXPECT_FALSE(tree.fixed_pose("base_link", "camera").has_value());
}

TEST(TransformTree, RefusesWhatIsNoTree) {
  const auto code = [](const TransformTree& tree, const std::string& frame) {
    return code_of(tree.poses_of(frame, "drive.mcap"));
  };
  EXPECT_EQ(code(driving(), "camera"), ErrorCode::kNoPoses);
  EXPECT_EQ(code(TransformTree(), "base_link"), ErrorCode::kNoPoses);
  TransformTree still;
  still.add(moved(0, "map", "base_link", 1.0), false);
  EXPECT_EQ(code(still, "base_link"), ErrorCode::kNoPoses);
  TransformTree circle = driving();
  circle.add(moved(0, "lidar", "odom", 1.0), false);
  EXPECT_EQ(code(circle, "lidar"), ErrorCode::kMalformedPose);
  TransformTree two_parents = driving();
  two_parents.add(moved(0, "map", "base_link", 1.0), false);
  EXPECT_EQ(code(two_parents, "lidar"), ErrorCode::kMalformedPose);
}

}  // namespace
}  // namespace sightline

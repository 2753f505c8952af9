#include "formats/foreign/ros/files/mcap_writer.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "formats/foreign/ros/files/open_message_log.h"
#include "formats/foreign/ros/message_writer.h"
#include "formats/foreign/ros/ros_bag.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

constexpr std::int64_t kFirst_ns = 1'567'410'201'000'000'005;

Pose pose_at(int i) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(456'500.25 + i, 5'429'500.0, 0.5);
  return pose;
}

// Poses, statuses and a path of so many scans.
std::vector<std::byte> written(int count) {
  std::vector<std::byte> bytes;
  const ByteSink file = [&](std::span<const std::byte> more) -> Result<void> {
    bytes.insert(bytes.end(), more.begin(), more.end());
    return {};
  };
  McapWriter writer(file);
  const std::uint16_t poses = writer.add_topic("/pose", kPoseWithCovarianceStamped);
  const std::uint16_t more_poses = writer.add_topic("/again", kPoseWithCovarianceStamped);
  const std::uint16_t statuses = writer.add_topic("/diagnostics", kDiagnosticArray);
  const std::uint16_t paths = writer.add_topic("/path", kPath);
  std::vector<StampedPose> way;
  for (int i = 0; i < count; ++i) {
    const std::int64_t stamp_ns = kFirst_ns + std::int64_t{100'000'000} * i;
    way.push_back({stamp_ns, pose_at(i)});
    Covariance covariance = Covariance::Identity() * i;
    EXPECT_TRUE(writer.add(poses, stamp_ns, pose_message(stamp_ns, "map", pose_at(i), covariance)));
    const Status status = {StatusLevel::kWarning, "n", "in doubt", "", {{"key", "value"}}};
    EXPECT_TRUE(writer.add(statuses, stamp_ns, status_message(stamp_ns, "map", status)));
  }
  (void)more_poses;
  EXPECT_TRUE(writer.add(paths, kFirst_ns, path_message("map", way)));
  EXPECT_TRUE(writer.finish());
  return bytes;
}

std::filesystem::path file_of(int count) {
  const std::filesystem::path path = scratch_folder() / (std::to_string(count) + ".mcap");
  EXPECT_TRUE(write_file_atomically(path, written(count), IfExists::kReplace));
  return path;
}

TEST(McapWriter, IsReadBackWithEveryMessage) {
  // 2500 scans fill more than one chunk.
  for (const int count : {1, 12, 2500}) {
    const std::unique_ptr<MessageLog> log = value_of(open_message_log(file_of(count)));
    EXPECT_TRUE(log->warnings().empty()) << log->warnings().front();
    std::map<std::string, std::uint64_t> counts;
    for (const auto& [id, channel] : log->channels()) {
      counts[channel.topic + " " + channel.type] = channel.message_count;
      EXPECT_EQ(channel.encoding, MessageEncoding::kCdr);
    }
    const auto all = static_cast<std::uint64_t>(count);
    const std::map<std::string, std::uint64_t> expected = {
        {"/again geometry_msgs/PoseWithCovarianceStamped", 0},
        {"/diagnostics diagnostic_msgs/DiagnosticArray", all},
        {"/path nav_msgs/Path", 1},
        {"/pose geometry_msgs/PoseWithCovarianceStamped", all}};
    EXPECT_EQ(counts, expected);
  }
}

TEST(McapWriter, KeepsPosesAndTimesToTheBit) {
  std::string frame;
  const std::vector<PoseRow> rows = value_of(read_bag_poses(file_of(12), "/pose", "", &frame));
  EXPECT_EQ(frame, "map");
  ASSERT_EQ(rows.size(), 12U);
  for (int i = 0; i < 12; ++i) {
    const PoseRow& row = rows[static_cast<std::size_t>(i)];
    EXPECT_EQ(row.stamp_ns, kFirst_ns + std::int64_t{100'000'000} * i);
    EXPECT_EQ(row.T_world_vehicle.translation(), pose_at(i).translation());
    EXPECT_TRUE(row.T_world_vehicle.linear().isApprox(pose_at(i).linear(), 1e-15));
  }
}

TEST(McapWriter, WritesEqualBytesForEqualMessages) { EXPECT_EQ(written(12), written(12)); }

TEST(McapWriter, WritesAFileWithoutMessages) {
  std::vector<std::byte> bytes;
  const ByteSink file = [&](std::span<const std::byte> more) -> Result<void> {
    bytes.insert(bytes.end(), more.begin(), more.end());
    return {};
  };
  McapWriter writer(file);
  EXPECT_TRUE(writer.finish());
  const std::filesystem::path path = scratch_folder() / "nothing.mcap";
  ASSERT_TRUE(write_file_atomically(path, bytes, IfExists::kReplace));
  const std::unique_ptr<MessageLog> log = value_of(open_message_log(path));
  EXPECT_TRUE(log->warnings().empty());
  EXPECT_TRUE(log->channels().empty());
}

TEST(McapWriter, HandsOnTheFailureOfItsFile) {
  const ByteSink full = [](std::span<const std::byte>) -> Result<void> {
    return Error{ErrorCode::kDiskFull, "full"};
  };
  McapWriter writer(full);
  EXPECT_EQ(writer.finish().error().code, ErrorCode::kDiskFull);
}

// Every changed byte of the data or the summary is noticed by a reader that checks checksums.
TEST(McapWriter, ChecksumsCoverEveryByteOfTheMessages) {
  const std::vector<std::byte> good = written(1);
  const std::filesystem::path path = scratch_folder() / "damaged.mcap";
  const std::string marker = "in doubt";
  const auto found = std::search(good.begin(), good.end(), std::as_bytes(std::span(marker)).begin(),
                                 std::as_bytes(std::span(marker)).end());
  ASSERT_NE(found, good.end());
  std::vector<std::byte> damaged = good;
  damaged[static_cast<std::size_t>(found - good.begin())] ^= std::byte{1};
  ASSERT_TRUE(write_file_atomically(path, damaged, IfExists::kReplace));
  const Result<std::unique_ptr<MessageLog>> log = open_message_log(path);
  bool is_noticed = !log;
  if (log) {
    std::set<std::uint32_t> all;
    for (const auto& [id, channel] : (*log)->channels()) all.insert(id);
    is_noticed =
        !(*log)->for_each_message(all, [](const LoggedMessage&) -> Result<void> { return {}; });
  }
  EXPECT_TRUE(is_noticed);
}

}  // namespace
}  // namespace sightline

#include "compiler/views/replay/replay_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/foreign/ros/files/open_message_log.h"
#include "formats/foreign/ros/ros_bag.h"
#include "formats/foreign/ros/ros_messages.h"
#include "formats/foreign/text/pose_file.h"
#include "tests/compiler/views/replay/small_replay.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;

class ReplayFiles : public TestInFolder {
 protected:
  std::filesystem::path written(const std::string& name) {
    const std::filesystem::path file = folder_ / name;
    const SmallReplay small = small_replay();
    EXPECT_TRUE(write_poses(file, small.scans, small.drive, IfExists::kRefuse));
    return file;
  }
};

TEST_F(ReplayFiles, InTumAreTheScansThatWereLocalized) {
  const std::vector<PoseRow> rows = value_of(read_poses(written("poses.tum"), PoseFormat::kTum));
  ASSERT_EQ(rows.size(), 7U) << "neither those that were lost nor the skipped one";
  EXPECT_EQ(rows[0].stamp_ns, 1'000'000'000'000);
  EXPECT_EQ(rows[6].stamp_ns, 1'000'900'000'000);
  EXPECT_EQ(rows[6].T_world_vehicle.translation(), Eigen::Vector3d(1009.0, -2.0, 0.5));
}

TEST_F(ReplayFiles, InCsvAreAllScans) {
  const std::string text = value_of(read_text_file(written("poses.csv")));
  EXPECT_THAT(text, HasSubstr("\n0,0.pcd,1000.000000000,localized,1000,-2,0.5,0,0,0,1,0.02,"));
  EXPECT_THAT(text, HasSubstr("\n2,2.pcd,1000.200000000,in doubt,"));
  EXPECT_THAT(text, HasSubstr(",forward yaw\n"));
  EXPECT_THAT(text, HasSubstr("\n7,7.pcd,1000.700000000,lost,,,"));
  EXPECT_THAT(text, HasSubstr("\n5,5.pcd,1000.500000000,skipped,,,"));
}

TEST_F(ReplayFiles, InMcapAreReadAsABag) {
  const std::filesystem::path file = written("poses.mcap");
  const std::vector<PoseRow> rows = value_of(read_bag_poses(file, "/sightline/pose"));
  ASSERT_EQ(rows.size(), 7U);
  EXPECT_EQ(rows[6].T_world_vehicle.translation(), Eigen::Vector3d(1009.0, -2.0, 0.5));
  std::map<std::string, std::uint64_t> counts;
  const std::unique_ptr<MessageLog> log = value_of(open_message_log(file));
  for (const auto& [id, channel] : log->channels()) {
    counts[channel.topic] = channel.message_count;
  }
  const std::map<std::string, std::uint64_t> expected = {
      {"/diagnostics", 9}, {"/sightline/path", 1}, {"/sightline/pose", 7}};
  EXPECT_EQ(counts, expected);
}

TEST_F(ReplayFiles, DoNotDependOnTimesOfTheComputation) {
  SmallReplay small = small_replay();
  const std::vector<std::byte> before = poses_mcap(small.scans, small.drive);
  for (ReplayedScan& scan : small.drive.scans) scan.time_ms *= 2.0;
  EXPECT_EQ(poses_mcap(small.scans, small.drive), before);
}

TEST_F(ReplayFiles, ReplaceNothingWithoutForce) {
  const std::filesystem::path file = written("poses.mcap");
  const SmallReplay small = small_replay();
  const Result<void> again = write_poses(file, small.scans, small.drive, IfExists::kRefuse);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kOutputExists);
}

}  // namespace
}  // namespace sightline

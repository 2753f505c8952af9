#include "passes/ingest/ingest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/text/pose_file.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class IngestTest : public testing::Test {
 protected:
  void write_ascii(std::string_view name, int count, std::string_view points) {
    const std::string number = std::to_string(count);
    folder_.write(name, "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH " + number +
                            "\nHEIGHT 1\nPOINTS " + number + "\nDATA ascii\n" +
                            std::string(points));
  }
  Recording open(std::string_view poses = "") {
    RecordingOptions options;
    options.scans = folder_.path().string();
    if (!poses.empty()) options.poses = folder_.write("poses.txt", poses).string();
    return value_of(open_recording(options));
  }

  ScratchFolder folder_;
  TestContext ctx_;
};

// Three points in millimetres, the second of which is withheld (LAS 1.2, point format 0).
std::string las_with_a_withheld_point() {
  std::string bytes(227 + 3 * 20, '\0');
  const auto put = [&](std::size_t at, auto value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
  };
  bytes.replace(0, 4, "LASF");
  put(24, std::uint16_t{0x0201});
  put(94, std::uint16_t{227});
  put(96, std::uint32_t{227});
  put(105, std::uint16_t{20});
  put(107, std::uint32_t{3});
  for (std::size_t axis = 0; axis < 3; ++axis) put(131 + 8 * axis, 0.001);
  for (std::size_t i = 0; i < 3; ++i) put(227 + 20 * i, static_cast<std::int32_t>(1000 * (i + 1)));
  put(227 + 20 + 15, std::uint8_t{0x80});
  return bytes;
}

TEST_F(IngestTest, SaysHowManyPointsTheirFilesWithhold) {
  folder_.write("0.las", las_with_a_withheld_point());
  EXPECT_EQ(value_of(ingest(ctx_, {}, open())).scans[0].point_count, 2U);
  EXPECT_THAT(ctx_.warnings,
              ElementsAre(HasSubstr("dropped 1 points that their files mark as withheld, kept 2")));
}

TEST_F(IngestTest, CountsWhatIsInEachScanAndWarnsOfWhatWasDropped) {
  write_ascii("0.pcd", 4, "1 2 3\nnan 0 0\n0 0 0\n4 5 6\n");
  write_ascii("1.pcd", 2, "0 0 0\n7 8 9\n");
  const Drive drive = value_of(ingest(ctx_, {}, open()));
  ASSERT_EQ(drive.scans.size(), 2U);
  EXPECT_EQ(drive.scans[0].point_count, 2U);
  EXPECT_EQ(drive.scans[0].nonfinite_count, 1U);
  EXPECT_EQ(drive.scans[0].zero_count, 1U);
  EXPECT_EQ(drive.scans[1].point_count, 1U);
  EXPECT_EQ(drive.scans[1].source, "1.pcd");
  EXPECT_EQ(drive.scans[1].recording_index, 1U);
  EXPECT_FALSE(drive.has_poses());
  EXPECT_EQ(drive.frame, MapFrame{});
  EXPECT_THAT(ctx_.warnings,
              ElementsAre(HasSubstr("dropped 1 NaN or infinite points and 2 at (0,0,0), kept 3")));
  const Scan scan = value_of(drive.store->read(1));
  EXPECT_EQ(scan.points_m, std::vector<Eigen::Vector3d>{Eigen::Vector3d(7, 8, 9)});
}

TEST_F(IngestTest, TheMapFrameBeginsNearTheFirstPoseAndPosesKeepTheirMillimetres) {
  write_ascii("1.pcd", 1, "1 2 3\n");
  const Drive drive = value_of(ingest(
      ctx_, {}, open("1 1223328152.391680 588348.947978 4141240.223859 -30.094324 0 0 0 1\n")));
  EXPECT_EQ(drive.frame.origin_world_m, Eigen::Vector3d(588288.0, 4141184.0, -64.0));
  EXPECT_EQ(drive.scans[0].stamp_ns, 1223328152391680000);
  const Pose T_map_vehicle = rebase(*drive.scans[0].T_world_vehicle, {}, drive.frame);
  EXPECT_TRUE(T_map_vehicle.translation().isApprox(Eigen::Vector3d(60.947978, 56.223859, 33.905676),
                                                   1e-10));
}

TEST_F(IngestTest, GivesTheSameDriveForAnyNumberOfThreads) {
  Random random(9);
  for (int i = 0; i < 12; ++i) {
    std::vector<PointXyzi> points(1 + random.below(50));
    for (PointXyzi& point : points) {
      point.x_m = random.below(4) > 0 ? static_cast<float>(random.uniform(-50.0, 50.0)) : 0.0F;
    }
    points[0].z_m = 1.0F;
    ASSERT_TRUE(write_pcd_binary(folder_ / (std::to_string(i) + ".pcd"), points).has_value());
  }
  const Recording recording = open();
  const Drive one = value_of(ingest(ctx_, {}, recording));
  const Drive four = value_of(ingest(TestContext(4), {}, recording));
  EXPECT_TRUE(validate(one).has_value());
  EXPECT_EQ(to_bytes(one), to_bytes(four));
}

TEST_F(IngestTest, RefusesTheFirstBadScanWhateverTheThreads) {
  for (const char* name : {"0.pcd", "1.pcd", "4.pcd"}) write_ascii(name, 1, "1 2 3\n");
  write_ascii("2.pcd", 2, "1 2 3\n");
  folder_.write("3.pcd", "");
  const Recording recording = open();
  for (const int threads : {1, 2, 4}) {
    const Error refused = failure_of(ingest(TestContext(threads), {}, recording));
    EXPECT_EQ(refused.code, ErrorCode::kTruncatedScan);
    EXPECT_EQ(refused.file, (folder_ / "2.pcd").string());
  }
}

TEST_F(IngestTest, RefusesTimesThatRunBackwardsAndNamesTheScan) {
  write_ascii("1.pcd", 1, "1 2 3\n");
  write_ascii("2.pcd", 1, "1 2 3\n");
  const Error refused =
      failure_of(ingest(ctx_, {}, open("2 10 0 0 0 0 0 0 1\n1 11 0 0 0 0 0 0 1\n")));
  EXPECT_EQ(refused.code, ErrorCode::kTimeRunsBackwards);
  EXPECT_EQ(refused.file, (folder_ / "2.pcd").string());
  EXPECT_EQ(refused.place, "scan 1");
}

TEST_F(IngestTest, WarnsOfTheFirstGapInTimeAndNamesItsScans) {
  std::string stamps;
  for (int i = 0; i < 8; ++i) {
    write_ascii(std::to_string(i) + ".pcd", 1, "1 2 3\n");
    stamps += std::to_string(i < 5 ? 100.0 + 0.1 * i : 102.5 + 0.1 * i) + "\n";
  }
  RecordingOptions options;
  options.scans = folder_.path().string();
  options.stamps = folder_.write("times.txt", stamps).string();
  ASSERT_TRUE(ingest(ctx_, {}, value_of(open_recording(options))).has_value());
  EXPECT_THAT(
      ctx_.warnings,
      ElementsAre(HasSubstr("1 gaps in time, the first of 2.600000000 s between scan 4 (4.pcd) "
                            "and scan 5 (5.pcd)")));
}

TEST_F(IngestTest, KeepsTheTimesOfPointsAndSaysWhereTheyMakeNoSense) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nproperty float time\nend_header\n";
  folder_.write("0.ply", header + "1 2 3 0\n4 5 6 0.05\n");
  folder_.write("1.ply", header + "1 2 3 0\n4 5 6 1e12\n");
  const Drive drive = value_of(ingest(ctx_, {}, open()));
  EXPECT_TRUE(drive.scans[0].has_point_times);
  EXPECT_FALSE(drive.scans[1].has_point_times);
  EXPECT_EQ(drive.store->read(0)->time_offset_ns, (std::vector<std::int32_t>{0, 50'000'000}));
  EXPECT_THAT(ctx_.warnings, ElementsAre(HasSubstr("1 scans have point times")));
}

// One of 20 has no points, one only such without a direction.
TEST_F(IngestTest, LeavesOutAFewScansWithoutReturnsAndReadsTheOthersFromTheirPlaces) {
  const auto write_all = [&](const std::vector<int>& empty) {
    for (int i = 0; i < 40; ++i) {
      write_ascii(std::to_string(i) + ".pcd", 1, std::to_string(i + 1) + " 2 3\n");
    }
    for (const int i : empty) write_ascii(std::to_string(i) + ".pcd", 0, "");
  };
  write_all({0});
  write_ascii("21.pcd", 2, "nan nan nan\n0 0 0\n");
  const Recording recording = open();
  const Drive drive = value_of(ingest(ctx_, {}, recording));
  ASSERT_EQ(drive.scans.size(), 38U);
  EXPECT_EQ(drive.scans[0].recording_index, 1U);
  EXPECT_EQ(drive.scans[20].recording_index, 22U);
  EXPECT_EQ(drive.scans[20].source, "22.pcd");
  EXPECT_THAT(
      ctx_.warnings,
      ElementsAre(HasSubstr("2 of 40 scans have no returns and are left out: 0.pcd, 21.pcd")));
  const Eigen::Vector3d expected(23, 2, 3);
  EXPECT_EQ(value_of(drive.store->read(20)).points_m.at(0), expected);
  Drive decoded = value_of(from_bytes<Drive>(to_bytes(drive)));
  reattach(decoded, recording);
  EXPECT_EQ(value_of(decoded.store->read(20)).points_m.at(0), expected);
  write_all({0, 1, 2});
  const Error refused = failure_of(ingest(ctx_, {}, open()));
  EXPECT_EQ(refused.code, ErrorCode::kEmptyScan);
  EXPECT_EQ(refused.file, (folder_ / "0.pcd").string());
}

TEST_F(IngestTest, NamesPointTimesThatAreNoneOfTheirScan) {
  const auto warnings_of = [&](const std::string& name, double first, double last) {
    for (int i = 0; i < 3; ++i) {
      folder_.write(std::to_string(i) + ".ply",
                    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                    "property float z\nproperty double " +
                        name + "\nend_header\n1 2 3 " +
                        std::to_string(first + 0.1 * i * (first > 1e3 ? 1 : 0)) + "\n4 5 6 " +
                        std::to_string(last + 0.1 * i * (first > 1e3 ? 1 : 0)) + "\n");
    }
    RecordingOptions options;
    options.scans = folder_.path().string();
    options.stamps = folder_.write("times.txt", "1600000000.0\n1600000000.1\n1600000000.2\n");
    ctx_.warnings.clear();
    const Drive drive = value_of(ingest(ctx_, {}, value_of(open_recording(options))));
    EXPECT_EQ(drive.scans[1].has_point_times, !drive.store->read(1)->time_offset_ns.empty());
    return ctx_.warnings;
  };
  EXPECT_THAT(warnings_of("time", 0.0, 0.1), testing::IsEmpty());
  EXPECT_THAT(warnings_of("time", 0.0, 1.0),
              ElementsAre(HasSubstr("the point times of 3 scans are from 0 to 1, but scans are 0.1 "
                                    "s apart; they are read as shares of a sweep of 0.1 s")));
  EXPECT_THAT(warnings_of("time", 0.0, 0.4),
              ElementsAre(HasSubstr("the point times of 3 scans span 0.4 s, but scans are 0.1 s "
                                    "apart; these times are ignored")));
  EXPECT_THAT(warnings_of("time", 1600000000.8, 1600000000.9),
              ElementsAre(HasSubstr("the point times of 3 scans begin 0.8 s after the times of the "
                                    "scans, so they are of another clock")));
  EXPECT_THAT(warnings_of("time", 5000.0, 5000.1), testing::IsEmpty())
      << "since it was switched on";
  EXPECT_THAT(warnings_of("stamp_of_point", 0.0, 0.1),
              ElementsAre(HasSubstr("the field `stamp_of_point` of the scans may contain times")));
}

TEST_F(IngestTest, RefusesADriveWithoutScans) {
  EXPECT_EQ(ingest(ctx_, {}, Recording{}).error().code, ErrorCode::kDriveTooShort);
}

TEST_F(IngestTest, WarnsOfCutText) {
  write_ascii("0.pcd", 1, "8.9 2.2 -0.1");
  ASSERT_TRUE(ingest(ctx_, {}, open()).has_value());
  EXPECT_THAT(ctx_.warnings, ElementsAre(HasSubstr("may be cut")));
}

TEST_F(IngestTest, RefusesScansThatMostlyLieFartherThanALidarSees) {
  write_ascii("0.pcd", 2, "1 2 3\n4 5 6\n");
  write_ascii("1.pcd", 1, "588348.9 4141240.2 -30.1\n");
  EXPECT_TRUE(ingest(ctx_, {}, open()).has_value());
  EXPECT_THAT(ctx_.warnings,
              ElementsAre(HasSubstr("1 scans have most of their points farther than 2 km")));
  write_ascii("2.pcd", 3, "12010 -3410 110\n15 20 30\n-8750 2100 -1800\n");
  const Error refused = failure_of(ingest(ctx_, {}, open()));
  EXPECT_EQ(refused.code, ErrorCode::kUnsupportedFormat);
  EXPECT_EQ(refused.file, (folder_ / "1.pcd").string());
  EXPECT_THAT(refused.message, HasSubstr("millimetres"));
}

TEST(IngestOptionFields, ReadBackAsTheyArePrinted) {
  RecordingOptions options;
  for (OptionField& field : option_fields(options)) {
    EXPECT_TRUE(set_from_text(field, to_text(field)).has_value()) << field.name;
  }
}

}  // namespace
}  // namespace sightline

#include <ctime>

#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/foreign/recording/left_out_scans.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/recording/point_times.h"
#include "formats/foreign/text/pose_file.h"
#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

class RecordingTest : public testing::Test {
 protected:
  void write_scans(std::initializer_list<const char*> names) {
    float x_m = 1.0F;
    for (const char* name : names) write_scan(name, x_m++);
  }
  void write_scan(const char* name, float x_m) {
    const PointXyzi point{x_m, 2.0F, 3.0F, 0.0F};
    ASSERT_TRUE(
        write_pcd_binary(folder_ / "scans" / name, std::span(&point, 1), IfExists::kReplace));
  }
  // One TUM row a second from `first` on, x = its index.
  static std::string tum(int count, int first = 0) {
    std::string text;
    for (int i = 0; i < count; ++i) {
      text.append(std::to_string(first + i)).append(" ").append(std::to_string(i));
      text.append(" 0 0 0 0 0 1\n");
    }
    return text;
  }
  RecordingOptions options(std::string_view poses = "", std::string_view stamps = "") {
    RecordingOptions made;
    made.scans = (folder_ / "scans").string();
    if (!poses.empty()) made.poses = folder_.write("poses.txt", poses).string();
    if (!stamps.empty()) made.stamps = folder_.write("times.txt", stamps).string();
    return made;
  }
  ErrorCode refusal(const RecordingOptions& made) { return code_of(open_recording(made)); }
  static double x_m(const RecordedScan& scan) { return scan.T_world_vehicle->translation().x(); }

  ScratchFolder folder_;
};

TEST_F(RecordingTest, WithoutPosesAndTimesScansFollowTheRate) {
  write_scans({"0.pcd", "1.pcd", "2.pcd"});
  const Recording recording = value_of(open_recording(options()));
  EXPECT_EQ(recording.name, "scans");
  EXPECT_EQ(recording.scans.at(2).stamp_ns, 200'000'000);
  EXPECT_FALSE(recording.scans.at(0).T_world_vehicle.has_value());
  EXPECT_TRUE(recording.warnings.empty());
}

TEST_F(RecordingTest, TumRowsBelongToScansByLineAndGiveTheirTimes) {
  write_scans({"a1.pcd", "a2.pcd"});
  const Recording recording = value_of(open_recording(options(tum(2, 100))));
  EXPECT_EQ(recording.scans.at(1).stamp_ns, 101'000'000'000);
  EXPECT_EQ(x_m(recording.scans.at(1)), 1.0);
}

TEST_F(RecordingTest, WhereThereAreMoreRowsTheNumberInTheNameIsTheRow) {
  write_scans({"000002.pcd", "000003.pcd"});
  const Recording recording = value_of(open_recording(options(tum(6))));
  EXPECT_EQ(x_m(recording.scans.at(0)), 2.0);
  EXPECT_EQ(x_m(recording.scans.at(1)), 3.0);
  ASSERT_EQ(recording.warnings.size(), 1U);
  EXPECT_THAT(recording.warnings.front(), HasSubstr("6 rows for 2 scans"));
}

TEST_F(RecordingTest, WhereNamesAreNoRowsTheFirstRowsAreUsed) {
  write_scans({"first.pcd", "second.pcd"});
  const Recording recording = value_of(open_recording(options(tum(6))));
  EXPECT_EQ(x_m(recording.scans.at(1)), 1.0);
  EXPECT_EQ(recording.warnings.size(), 1U);
}

TEST_F(RecordingTest, ScansNamedByTimeTakeThePoseOfThatTime) {
  write_scans({"100500000000000000.pcd", "101000000000000000.pcd"});
  const Recording recording = value_of(open_recording(
      options("100500000 1 0 0 0 0 0 1\n100999999.5 3 0 0 0 0 0 1\n101000000.5 5 0 0 0 0 0 1\n")));
  EXPECT_EQ(x_m(recording.scans.at(0)), 1.0);
  EXPECT_NEAR(x_m(recording.scans.at(1)), 4.0, 1e-12);  // halfway between two rows
  EXPECT_EQ(recording.scans.at(1).stamp_ns, 101000000000000000);
}

TEST_F(RecordingTest, StampsFileGivesTimesAndTumIsInterpolatedAtThem) {
  write_scans({"0.pcd", "1.pcd"});
  const Recording recording = value_of(open_recording(options(tum(5), "0.25\n3.5\n")));
  EXPECT_NEAR(x_m(recording.scans.at(0)), 0.25, 1e-12);
  EXPECT_NEAR(x_m(recording.scans.at(1)), 3.5, 1e-12);
  EXPECT_EQ(recording.scans.at(1).stamp_ns, 3'500'000'000);
}

TEST_F(RecordingTest, ApolloRowsBelongToScansById) {
  write_scans({"1.pcd", "2.pcd"});
  const Recording recording = value_of(
      open_recording(options("2 10.5 22 0 0 0 0 0 1\n3 11 33 0 0 0 0 0 1\n1 12 11 0 0 0 0 0 1\n")));
  EXPECT_EQ(x_m(recording.scans.at(0)), 11.0);
  EXPECT_EQ(x_m(recording.scans.at(1)), 22.0);
  EXPECT_EQ(refusal(options("2 10.5 22 0 0 0 0 0 1\n3 11 33 0 0 0 0 0 1\n")),
            ErrorCode::kFewerPosesThanScans);
}

TEST_F(RecordingTest, RefusesFewerPosesOrTimesThanScans) {
  write_scans({"0.pcd", "1.pcd", "2.pcd"});
  const Error error = failure_of(open_recording(options(tum(2))));
  EXPECT_EQ(error.code, ErrorCode::kFewerPosesThanScans);
  EXPECT_THAT(error.message, HasSubstr("found 2 poses for 3 scans"));
  EXPECT_EQ(refusal(options("# none\n")), ErrorCode::kFewerPosesThanScans);
  EXPECT_EQ(refusal(options("", "1\n2\n")), ErrorCode::kMismatchedInputs);
  EXPECT_EQ(refusal(options(tum(3), "7\n8\n9\n")), ErrorCode::kFewerPosesThanScans);
}

// 40 scans of 10 Hz from 0.5 s on.
TEST_F(RecordingTest, LeavesOutScansBeforeTheFirstAndAfterTheLastPose) {
  std::string stamps;
  for (int i = 0; i < 40; ++i) {
    write_scan((std::to_string(i) + ".pcd").c_str(), 1.0F);
    stamps += std::to_string(0.5 + 0.1 * i) + "\n";
  }
  const Recording recording = value_of(open_recording(options(tum(3, 1), stamps)));
  ASSERT_EQ(recording.scans.size(), 21U) << "from 1 to 3 s";
  EXPECT_EQ(recording.scans.front().name, "5.pcd");
  EXPECT_EQ(recording.scans.front().index, 5U);
  ASSERT_FALSE(recording.warnings.empty());
  EXPECT_THAT(recording.warnings.back(),
              HasSubstr("19 of 40 scans have no pose: 5 before the first pose, 14 after the last, "
                        "0 between. They are left out"));
}

// Receivers of 1 Hz are some milliseconds early or late.
TEST_F(RecordingTest, InterpolatesPosesAcrossAJitteringSecondAndLeavesOutScansInAFewGaps) {
  const std::string_view tum =
      "0 0 0 0 0 0 0 1\n1.005 1 0 0 0 0 0 1\n2.01 2 0 0 0 0 0 1\n"
      "3.6 3 0 0 0 0 0 1\n4.6 4 0 0 0 0 0 1\n";
  std::string stamps;
  for (int i = 0; i < 40; ++i) {
    write_scan((std::to_string(i) + ".pcd").c_str(), 1.0F);
    stamps += std::to_string(i < 20 ? 0.1 * i : 3.6 + 0.05 * (i - 20)) + "\n";
  }
  const Recording whole = value_of(open_recording(options(tum, stamps)));
  EXPECT_EQ(whole.scans.size(), 40U);
  write_scan("40.pcd", 1.0F);
  const Recording recording = value_of(
      open_recording(options(tum, stamps.substr(0, 9 * 20) + "2.5\n" + stamps.substr(9 * 20))));
  EXPECT_EQ(recording.scans.size(), 40U) << "one is in the gap of 1.59 s";
  EXPECT_THAT(recording.warnings, testing::Contains(HasSubstr("0 after the last, 1 between")));
  stamps.replace(9 * 10, 9 * 10, "2.1\n2.2\n2.3\n2.4\n2.5\n2.6\n2.7\n2.8\n2.9\n3.0\n");
  std::filesystem::remove(folder_ / "scans/40.pcd");
  EXPECT_EQ(refusal(options(tum, stamps)), ErrorCode::kFewerPosesThanScans);
}

TEST_F(RecordingTest, LeavesOutTheFewestScansWhoseTimesDoNotAscend) {
  for (int i = 0; i < 40; ++i) {
    write_scan((std::to_string(1'600'000'000 + i) + ".000000.pcd").c_str(), 1.0F);
  }
  RecordingOptions made = options();
  Recording recording = value_of(list_recording(made));
  recording.scans[7].stamp_ns += 3'600'000'000'000;  // an hour ahead of the 32 behind it
  recording.scans[20].stamp_ns = recording.scans[19].stamp_ns;
  leave_out_untimely(recording);
  ASSERT_EQ(recording.scans.size(), 38U);
  EXPECT_EQ(recording.scans[7].index, 8U);
  EXPECT_EQ(recording.scans[18].index, 19U);
  EXPECT_EQ(recording.scans[19].index, 21U);
  ASSERT_EQ(recording.warnings.size(), 1U);
  EXPECT_THAT(recording.warnings[0],
              HasSubstr("2 of 40 scans have the time of another scan or one out of order and are "
                        "left out: 1600000007.000000.pcd, 1600000020.000000.pcd"));
  for (std::size_t i = 0; i < 4; ++i) recording.scans[i].stamp_ns = 0;
  leave_out_untimely(recording);
  EXPECT_EQ(recording.scans.size(), 38U) << "three are more than 5 %";
}

TEST_F(RecordingTest, SettlesTheTimesOfPointsByTheStepBetweenScans) {
  const auto settle = [](std::vector<std::int32_t> times_ns, std::optional<std::int64_t> origin_ns,
                         std::int64_t step_ns = 100'000'000) {
    PointCloudFile cloud;
    cloud.time_offset_ns = std::move(times_ns);
    cloud.time_origin_ns = origin_ns;
    const SettledTimes settled = settle_point_times(5'000'000'000, step_ns, cloud);
    return std::make_pair(settled.kind, cloud.time_offset_ns);
  };
  using enum PointTimesKind;
  using Times = std::vector<std::int32_t>;
  const Times sweep = {0, 50'000'000, 99'000'000};
  const Times shares = {0, 500'000'000, 990'000'000};
  EXPECT_EQ(settle(sweep, std::nullopt), std::make_pair(kOfStamp, sweep));
  EXPECT_EQ(settle(shares, std::nullopt), std::make_pair(kShares, sweep));
  EXPECT_EQ(settle(shares, std::nullopt, 1'000'000'000), std::make_pair(kOfStamp, shares));
  EXPECT_EQ(settle(shares, 5'000'000'000), std::make_pair(kTooLong, Times())) << "of a clock";
  EXPECT_EQ(settle({0, 300'000'000}, std::nullopt), std::make_pair(kTooLong, Times()));
  const Times before = {-99'000'000, -49'000'000, 0};
  EXPECT_EQ(settle(sweep, 4'901'000'000), std::make_pair(kOfStamp, before)) << "stamped at the end";
  for (const long long ahead_ns :
       {-40'000'000'000LL, -300'000'000LL, 800'000'000LL, 40'000'000'000LL}) {
    EXPECT_EQ(settle(sweep, 5'000'000'000 + ahead_ns), std::make_pair(kOtherClock, sweep));
  }
}

TEST_F(RecordingTest, RefusesOptionsThatContradictThemselves) {
  write_scans({"0.pcd"});
  RecordingOptions made = options();
  made.sensor = "vlp-61";
  EXPECT_EQ(refusal(made), ErrorCode::kUnknownName);
  made = options();
  made.poses_of = PosesOf::kSensor;
  made.lidar_z_m = 1.8;
  EXPECT_EQ(refusal(made), ErrorCode::kBadValue);
  made = options();
  made.rate_hz = 0.0;
  EXPECT_EQ(refusal(made), ErrorCode::kBadValue);
  made = options();
  made.rings = 1;
  EXPECT_EQ(refusal(made), ErrorCode::kBadValue);
}

TEST_F(RecordingTest, TheSensorIsDescribedByItsProfileAndItsMounting) {
  write_scans({"0.pcd"});
  RecordingOptions made = options();
  made.rings = 3;
  made.height_m = 2.5;
  made.lidar_x_m = 1.0;
  made.lidar_yaw_deg = 90.0;
  const Recording recording = value_of(open_recording(made));
  const SensorProfile& sensor = recording.sensor;
  EXPECT_EQ(sensor.beam_elevations_deg, (std::vector<double>{-15.0, 0.0, 15.0}));
  EXPECT_EQ(sensor.height_m, 2.5);
  EXPECT_TRUE((sensor.T_vehicle_lidar * Eigen::Vector3d::UnitX())
                  .isApprox(Eigen::Vector3d(1.0, 1.0, 0.0), 1e-12));
}

TEST_F(RecordingTest, ItsDigestNamesContentsAndNotPlaces) {
  write_scans({"0.pcd", "1.pcd"});
  const Digest digest = open_recording(options(tum(2)))->digest;
  EXPECT_EQ(open_recording(options(tum(2)), 2)->digest, digest);
  std::filesystem::create_directory(folder_ / "elsewhere");
  std::filesystem::copy(folder_ / "scans", folder_ / "elsewhere" / "scans");
  RecordingOptions moved = options(tum(2));
  moved.scans = (folder_ / "elsewhere" / "scans/").string();
  EXPECT_EQ(open_recording(moved)->digest, digest);
  EXPECT_NE(open_recording(options())->digest, digest);
  EXPECT_NE(open_recording(options(tum(2, 1)))->digest, digest);
  write_scan("1.pcd", 9.0F);
  EXPECT_NE(open_recording(options(tum(2)))->digest, digest);
}

TEST_F(RecordingTest, ItsScansKeepTheirNamesWhenItGrows) {
  write_scans({"0.pcd", "1.pcd"});
  const auto names = [&](std::string_view stamps = "") {
    const auto store = recorded_scan_store(*open_recording(options("", stamps)));
    return std::make_pair(*store->identity(0), *store->identity(1));
  };
  const auto before = names();
  EXPECT_NE(before.first, before.second);
  write_scans({"2.pcd"});
  EXPECT_EQ(names(), before);
  write_scans({"3.pcd"});
  EXPECT_NE(names("0\n0.12\n0.22\n0.32\n").second, before.second);
  EXPECT_EQ(names("0\n0.12\n0.22\n0.32\n").first, before.first);
  std::filesystem::remove(folder_ / "scans/1.pcd");
  write_scans({"1.pcd"});
  EXPECT_NE(names().second, before.second);
}

TEST_F(RecordingTest, ItsStoreReadsScansAndNoticesWhenAFileChanged) {
  write_scans({"0.pcd", "1.pcd"});
  const Recording recording = value_of(open_recording(options(tum(2))));
  const std::shared_ptr<const ScanStore> store = recorded_scan_store(recording);
  const Scan scan = value_of(store->read(1));
  EXPECT_EQ(scan.stamp_ns, 1'000'000'000);
  EXPECT_EQ(scan.points_m, std::vector<Eigen::Vector3d>{Eigen::Vector3d(2, 2, 3)});
  write_scan("1.pcd", 9.0F);
  EXPECT_EQ(store->read(1).error().code, ErrorCode::kMismatchedInputs);
  EXPECT_TRUE(store->read(0).has_value());
}

// The first point is 1.9 s behind the stamp, the last one 3.4 s: more than 32 bits hold.
TEST_F(RecordingTest, TimesOfPointsTooFarBehindTheStampCountFromTheFirstPoint) {
  const auto offsets_ns = [&](const std::string& stamp_s) {
    const std::string header =
        "VERSION .7\nFIELDS x y z timestamp\nSIZE 4 4 4 8\nTYPE F F F F\nCOUNT 1 1 1 1\n"
        "WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n";
    folder_.write("scans/0.pcd", header + "1 2 3 100.0\n4 5 6 101.5\n");
    return value_of(recorded_scan_store(*open_recording(options("", stamp_s)))->read(0))
        .time_offset_ns;
  };
  EXPECT_EQ(offsets_ns("99.5\n"), (std::vector<std::int32_t>{500'000'000, 2'000'000'000}));
  EXPECT_EQ(offsets_ns("98.1\n"), (std::vector<std::int32_t>{0, 1'500'000'000}));
  EXPECT_EQ(offsets_ns("101.5\n"), (std::vector<std::int32_t>{-1'500'000'000, 0}));
}

// Poses in another order than the scans, and a row of an id that has one already, which is not
// used.
std::string apollo_rows(int count, std::vector<std::filesystem::path>& files) {
  std::string rows;
  for (int i = 0; i < count; ++i) {
    files.emplace_back(std::to_string(i) + ".pcd");
    const std::string id = std::to_string(count - 1 - i);
    rows += id + " " + std::to_string(i) + " " + id + " 0 0 0 0 0 1\n";
  }
  return rows + "7 " + std::to_string(count) + " 1 0 0 0 0 0 1\n";
}

TEST_F(RecordingTest, ApolloRowsAreFoundByIdInTimeInProportion) {
  constexpr int kCount = 64'000;
  Recording recording;
  const auto cpu_of = [&](int count) {
    std::vector<std::filesystem::path> files;
    const RecordingOptions all = options(apollo_rows(count, files));
    recording = Recording();
    const std::clock_t begin = std::clock();
    const Result<void> described = describe_scans(all, files, recording);
    EXPECT_TRUE(described.has_value()) << to_string(described.error());
    return std::clock() - begin;
  };
  const std::clock_t eighth = cpu_of(kCount / 8);
  EXPECT_LT(cpu_of(kCount), 24 * eighth);
  for (const int i : {0, 7, kCount - 1}) {
    EXPECT_EQ(x_m(recording.scans.at(static_cast<std::size_t>(i))), static_cast<double>(i));
  }
}

class HeaderlessRecording : public RecordingTest {
 protected:
  void write_bins(std::initializer_list<std::string> contents) {
    int index = 0;
    for (const std::string& content : contents) {
      folder_.write("scans/" + std::to_string(index++) + ".bin", content);
    }
  }
  RecordingOptions with_columns(const std::string& columns) {
    RecordingOptions made = options();
    made.columns = columns;
    return made;
  }
  std::size_t count_of(const RecordingOptions& made) {
    return value_of(open_recording(made)).columns->count;
  }
};

TEST_F(HeaderlessRecording, TakesTheCountThatFitsAllScansAndSaysSo) {
  write_bins({float_spiral(5), float_spiral(5, 8), float_spiral(5, 2400)});
  const Recording recording = value_of(open_recording(options()));
  EXPECT_EQ(to_text(*recording.columns), "x y z intensity _");
  ASSERT_EQ(recording.warnings.size(), 1U);
  EXPECT_THAT(recording.warnings[0], HasSubstr("`columns: x y z intensity _`"));
  EXPECT_EQ(recorded_scan_store(recording)->read(1)->points_m.size(), 8U);
  write_bins({float_spiral(4), float_spiral(4), float_spiral(4)});
  EXPECT_EQ(count_of(options()), 4U);
  EXPECT_TRUE(open_recording(options())->warnings.empty());
}

TEST_F(HeaderlessRecording, RefusesScansThatSpeakForDifferentCounts) {
  write_bins({float_spiral(4), float_spiral(4, 2), float_spiral(5)});
  const Error error = failure_of(open_recording(options()));
  EXPECT_EQ(error.code, ErrorCode::kMixedFormats);
  EXPECT_THAT(error.message, HasSubstr("4 fit up to 1.bin, 5 fit 2.bin"));
}

TEST_F(HeaderlessRecording, RefusesWhatFitsNothingOrTooMuchByItsFile) {
  write_bins({float_spiral(4), std::string(32000, '\1')});
  const Error error = failure_of(open_recording(options()));
  EXPECT_EQ(error.code, ErrorCode::kUnsupportedFormat);
  EXPECT_EQ(error.file, (folder_ / "scans/1.bin").string());
  write_bins({float_spiral(4, 6), float_spiral(4, 12)});
  EXPECT_EQ(refusal(options()), ErrorCode::kUnsupportedFormat);
  write_bins({float_spiral(4), float_spiral(4) + "cut"});
  EXPECT_EQ(open_recording(options()).error().file, (folder_ / "scans/1.bin").string());
  EXPECT_EQ(refusal(options()), ErrorCode::kTruncatedScan);
}

TEST_F(HeaderlessRecording, BelievesGivenColumnsUnlessTheFloatsCannotBeThem) {
  write_bins({float_spiral(4, 6), float_spiral(4, 12)});
  EXPECT_EQ(count_of(with_columns("4")), 4U);
  EXPECT_EQ(count_of(with_columns("x, y, z, intensity")), 4U);
  write_bins({float_spiral(5), float_spiral(5)});
  EXPECT_EQ(count_of(with_columns("x y z intensity ring")), 5U);
  EXPECT_EQ(refusal(with_columns("4")), ErrorCode::kUnsupportedFormat);
  EXPECT_EQ(refusal(with_columns("x y")), ErrorCode::kBadValue);
}

TEST_F(HeaderlessRecording, ItsDigestNamesItsColumnsAndNotHowTheyAreWritten) {
  write_bins({float_spiral(6), float_spiral(6)});
  const Digest six = open_recording(options())->digest;
  EXPECT_EQ(open_recording(with_columns("x y z i _ _"))->digest, six);
  EXPECT_NE(open_recording(with_columns("y x z i _ _"))->digest, six);
}

TEST_F(HeaderlessRecording, OnlyIsGivenColumns) {
  write_scans({"0.pcd"});
  EXPECT_EQ(refusal(with_columns("4")), ErrorCode::kBadValue);
}

}  // namespace
}  // namespace sightline

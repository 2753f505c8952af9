#include "formats/foreign/text/pose_file.h"

#include "formats/foreign/text/stamp.h"

#include "formats/base/random.h"
#include "formats/base/units.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using enum ErrorCode;

Result<std::vector<PoseRow>> read(const ScratchFolder& folder, std::string_view text,
                                  PoseFormat format = PoseFormat::kAuto) {
  return read_poses(folder.write("poses.txt", text), format);
}

void expect_refused(const std::string& text, ErrorCode code, const std::string& place) {
  const ScratchFolder folder;
  const Error error = failure_of(read(folder, text), text);
  EXPECT_EQ(error.code, code) << to_string(error);
  EXPECT_EQ(error.place, place) << to_string(error);
  EXPECT_EQ(error.file, (folder / "poses.txt").string());
}

TEST(PoseFile, ReadsKittiTumAndApolloByTheirColumns) {
  const ScratchFolder folder;
  const auto kitti = value_of(read(folder, "0 -1 0 10\t1 0 0 20,0 0 1 30\r\n"));
  EXPECT_TRUE((kitti.at(0).T_world_vehicle * Eigen::Vector3d::UnitX())
                  .isApprox(Eigen::Vector3d(10, 21, 30), 1e-12));
  EXPECT_FALSE(kitti.at(0).stamp_ns.has_value());

  const auto tum =
      value_of(read(folder, "# t x y z qx qy qz qw\n\n  # more\n1.5 10 20 30 0 0 1 0\n"));
  EXPECT_EQ(tum.at(0).stamp_ns, 1'500'000'000);
  EXPECT_TRUE((tum.at(0).T_world_vehicle * Eigen::Vector3d::UnitX())
                  .isApprox(Eigen::Vector3d(9, 20, 30), 1e-12));

  const auto apollo = value_of(read(folder, "7 1.5 10 20 30 0 0 1 0"));
  EXPECT_EQ(apollo.at(0).id, 7);
  EXPECT_EQ(apollo.at(0).stamp_ns, 1'500'000'000);
  EXPECT_TRUE(apollo.at(0).T_world_vehicle.isApprox(tum.at(0).T_world_vehicle));
}

TEST(PoseFile, ReadsWhatSpreadsheetsAndWindowsWrite) {
  const ScratchFolder folder;
  for (const char* head :
       {"timestamp,x,y,z,qx,qy,qz,qw\n", "t,pos_x,pos_y,pos_z,q.X,q.Y,q.Z,q.W\r\n", "\xef\xbb\xbf",
        "\xef\xbb\xbf# t x y z qx qy qz qw\n"}) {
    const auto poses = value_of(read(folder, std::string(head) + "1.5,10,20,30,0,0,1,0\r\n"), head);
    ASSERT_EQ(poses.size(), 1U) << head;
    EXPECT_EQ(poses.at(0).stamp_ns, 1'500'000'000);
  }
}

TEST(PoseFile, SaysWhatToDoWithAnotherLayout) {
  const ScratchFolder folder;
  const auto complaint = [&](std::string_view text) {
    const auto poses = read(folder, text);
    return poses ? std::string() : to_string(poses.error());
  };
  const std::string w_first = complaint("t x y z qw qx qy qz\n0 1 2 3 1 0 0 0\n");
  EXPECT_THAT(w_first, HasSubstr("in the order t x y z qx qy qz qw"));
  EXPECT_THAT(complaint("0,5;1,0;2,0;3,0;0,0;0,0;0,0;1,0\n"), HasSubstr("points in numbers"));
  // A line of names further down is no head.
  EXPECT_NE(complaint("0 1 2 3 0 0 0 1\nt x y z qx qy qz qw\n"), "");
}

TEST(PoseFile, TimesKeepEveryNanosecond) {
  EXPECT_EQ(parse_stamp_ns("1223328152.391680"), 1223328152391680000);
  EXPECT_EQ(parse_stamp_ns("1567410201.7452047"), 1567410201745204700);
  EXPECT_EQ(parse_stamp_ns("1403636579.763555450"), 1403636579763555450);
  EXPECT_EQ(parse_stamp_ns("1.403636579763555450e+09"), 1403636579763555450);
  EXPECT_EQ(parse_stamp_ns("1.036224e-01"), 103622400);
  EXPECT_EQ(parse_stamp_ns("1567410201745204736"), 1567410201745204736);   // ns
  EXPECT_EQ(parse_stamp_ns("1567410201745204"), 1567410201745204000);      // us
  EXPECT_EQ(parse_stamp_ns("1567410201745"), 1567410201745000000);         // ms
  EXPECT_EQ(parse_stamp_ns("1567410201745.204736"), 1567410201745204736);  // ms
  EXPECT_EQ(parse_stamp_ns("0.0000000005"), 1);
  EXPECT_EQ(parse_stamp_ns("0.00000000049"), 0);
  EXPECT_EQ(parse_stamp_ns("12"), 12'000'000'000);
  EXPECT_EQ(parse_stamp_ns("0"), 0);
  EXPECT_EQ(parse_stamp_ns("-1.5"), -1'500'000'000);
  EXPECT_EQ(parse_stamp_ns(".5"), 500'000'000);
  for (const std::string_view bad : {"", ".", "nan", "1.2.3", "1e", "1e99", "0x10", "99999999999.5",
                                     "99999999999999999999", "1 2"}) {
    EXPECT_EQ(parse_stamp_ns(bad), std::nullopt) << bad;
  }
  EXPECT_EQ(format_stamp(1403636579763555450), "1403636579.763555450");
  EXPECT_EQ(format_stamp(-1), "-0.000000001");
}

TEST(PoseFile, TimesThatFitNoDriveAsSecondsAreOfAFinerUnit) {
  const auto unit_of = [](std::int64_t step_ns) {
    std::vector<std::int64_t> stamps_ns = {0, step_ns, 2 * step_ns, 5 * step_ns};
    const std::string unit = take_finer_unit(stamps_ns);
    return unit + " " + format_stamp(stamps_ns[1]);
  };
  EXPECT_EQ(unit_of(100 * kSecond_ns), "milliseconds 0.100000000");
  EXPECT_EQ(unit_of(100'000 * kSecond_ns), "microseconds 0.100000000");
  EXPECT_EQ(unit_of(1 * kSecond_ns), " 1.000000000") << "a keyframe a second";
  EXPECT_EQ(unit_of(100 * kSecond_ns + 1), " 100.000000001") << "written with a point";
}

TEST(PoseFile, EveryStampReadsBackAsItWasWritten) {
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const auto stamp_ns = static_cast<std::int64_t>(random.next() >> (2 + random.below(60)));
    EXPECT_EQ(parse_stamp_ns(format_stamp(stamp_ns)), stamp_ns);
  }
}

TEST(PoseFile, WhatWriteTumWritesReadsBack) {
  const ScratchFolder folder;
  Random random(6);
  std::vector<PoseRow> rows;
  for (std::int64_t i = 0; i < 100; ++i) {
    PoseRow& row = rows.emplace_back();
    row.stamp_ns = 1'500'000'000'000'000'001 + i * 100'000'000;
    Eigen::Quaterniond rotation(random.normal(), random.normal(), random.normal(), random.normal());
    row.T_world_vehicle.linear() = rotation.normalized().toRotationMatrix();
    row.T_world_vehicle.translation() =
        Eigen::Vector3d(588348.947978 + static_cast<double>(i), 4141240.223859, -30.094324);
  }
  ASSERT_TRUE(write_tum(folder / "out.tum", rows).has_value());
  const std::vector<PoseRow> back = value_of(read_poses(folder / "out.tum", PoseFormat::kTum));
  ASSERT_EQ(back.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(back[i].stamp_ns, rows[i].stamp_ns);
    EXPECT_EQ(back[i].T_world_vehicle.translation(), rows[i].T_world_vehicle.translation());
    EXPECT_TRUE(back[i].T_world_vehicle.isApprox(rows[i].T_world_vehicle, 1e-12));
  }
  EXPECT_EQ(write_tum(folder / "out.tum", rows).error().code, kOutputExists);
}

TEST(PoseFile, MakesRoundedRotationsExactAndRefusesOthers) {
  const ScratchFolder folder;
  const auto rounded = value_of(read(folder, "0.99999 -0.0045 0 1 0.0045 0.99999 0 2 0 0 1 3\n"));
  EXPECT_TRUE(is_rigid(rounded.at(0).T_world_vehicle));
  EXPECT_NEAR(rounded.at(0).T_world_vehicle(1, 0), 0.0045, 1e-5);
  const auto quaternion = value_of(read(folder, "0 1 2 3 0 0 0.70716 0.70716\n"));
  EXPECT_TRUE(is_rigid(quaternion.at(0).T_world_vehicle));

  const std::string good = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  expect_refused(good + "1.1 0 0 0 0 1 0 0 0 0 1 0\n", kNotARotation, "line 2");
  expect_refused(good + "-1 0 0 0 0 1 0 0 0 0 1 0\n", kNotARotation,
                 "line 2");  // mirror
  expect_refused(good + "0 0 0 0 0 0 0 0 0 0 0 0\n", kNotARotation, "line 2");
  expect_refused("# one\n1 0 0 0 0 0 0 1.01\n", kNotARotation, "line 2");
  expect_refused("1 0 0 0 0 0 0 0\n", kNotARotation, "line 1");
}

TEST(PoseFile, RefusesWhatIsNoPoseAndNamesTheLine) {
  expect_refused("1 2 3\n", kMalformedPose, "line 1");
  expect_refused("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 1\n", kMalformedPose, "line 2");
  expect_refused("1 0 0 0 0 0 0 1\n1 2 0 0 0 0 0 0 1\n", kMalformedPose, "line 2");
  expect_refused("1 0 0 nan 0 0 0 1\n", kMalformedPose, "line 1");
  expect_refused("1 0 0 inf 0 0 0 1\n", kMalformedPose, "line 1");
  expect_refused("noon 0 0 0 0 0 0 1\n", kMalformedPose, "line 1");
  expect_refused("a 1 0 0 0 0 0 0 1\n", kMalformedPose, "line 1");
  expect_refused("2 0 0 0 0 0 0 1\n\n1 0 0 0 0 0 0 1\n", kTimeRunsBackwards, "line 3");
  expect_refused("2 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n", kTimeRunsBackwards, "line 2");
  expect_refused("version https://git-lfs.github.com/spec/v1\n", kGitLfsPointer, "line 1");
  const ScratchFolder folder;
  EXPECT_EQ(read(folder, "1 0 0 0 0 0 0 1\n", PoseFormat::kKitti).error().code, kMalformedPose);
  EXPECT_EQ(read_poses(folder / "none.txt", PoseFormat::kAuto).error().code, kFileNotFound);
}

TEST(PoseFile, KeepsAFewRowsOfEqualTimes) {
  const ScratchFolder folder;
  std::string text;
  for (int i = 0; i < 40; ++i) {
    text += std::to_string(i < 20 ? i : i - 1) + " " + std::to_string(i) + " 0 0 0 0 0 1\n";
  }
  EXPECT_EQ(value_of(read(folder, text, PoseFormat::kTum)).size(), 40U);
  text += "38 0 0 0 0 0 0 1\n38 0 0 0 0 0 0 1\n38 0 0 0 0 0 0 1\n";
  const Error error = failure_of(read(folder, text, PoseFormat::kTum));
  EXPECT_EQ(error.code, kTimeRunsBackwards);
  EXPECT_EQ(error.place, "line 21");
}

TEST(PoseFile, ReadsStampsAndRefusesThoseThatRunBackwards) {
  const ScratchFolder folder;
  const auto stamps =
      value_of(read_stamps(folder.write("times.txt", "# s\n0.5\n1.0e0 extra\n\n1.5\n")));
  EXPECT_EQ(stamps, (std::vector<std::int64_t>{500'000'000, 1'000'000'000, 1'500'000'000}));
  EXPECT_EQ(read_stamps(folder.write("times.txt", "2\n1\n")).error().code, kTimeRunsBackwards);
  EXPECT_EQ(read_stamps(folder.write("times.txt", "early\n")).error().code, kMalformedText);
}

}  // namespace
}  // namespace sightline

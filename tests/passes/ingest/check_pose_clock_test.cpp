#include "passes/ingest/check_pose_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "formats/base/random.h"
#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/geometry.h"
#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

using testing::HasSubstr;

// A minute among posts at 5 m/s, a scan every half second, poses every tenth.
class CheckPoseClockTest : public testing::Test {
 protected:
  static constexpr double kStep_s = 0.1;
  static constexpr std::size_t kFirstScan = 400;  // step; poses begin 40 s earlier

  static std::vector<Pose> way(bool is_winding) {
    std::vector<Pose> poses;
    Pose pose = Pose::Identity();
    for (int i = 0; i < 1400; ++i) {
      const double time_s = kStep_s * i;
      const double turn_rad =
          is_winding ? 0.06 * std::sin(0.4 * time_s + 2.0 * std::sin(0.11 * time_s)) : 0.0;
      pose.translate(Eigen::Vector3d(5.0 * kStep_s, 0.0, 0.0));
      pose.rotate(rotation_matrix({Eigen::Vector3d::UnitZ(), turn_rad}));
      poses.push_back(pose);
    }
    return poses;
  }
  static std::vector<Eigen::Vector3d> posts(const std::vector<Pose>& way) {
    Random random(11);
    std::vector<Eigen::Vector3d> posts_m;
    for (std::size_t i = kFirstScan; i < 1000; i += 2) {
      const Eigen::Vector3d at_m(random.uniform(-25.0, 25.0), random.uniform(-25.0, 25.0), 0.0);
      posts_m.emplace_back(way[i] * at_m);
    }
    return posts_m;
  }
  Recording record(bool is_winding, double poses_late_s) {
    const std::vector<Pose> poses = way(is_winding);
    const std::vector<Eigen::Vector3d> posts_m = posts(poses);
    for (std::size_t i = kFirstScan; i < 1000; i += 5) {
      std::vector<PointXyzi> points;
      for (const Eigen::Vector3d& post_m : posts_m) {
        const Eigen::Vector3d seen_m = poses[i].inverse() * post_m;
        for (const double z_m : {0.1, 0.7, 1.3}) {
          points.push_back({static_cast<float>(seen_m.x()), static_cast<float>(seen_m.y()),
                            static_cast<float>(z_m), 0.0F});
        }
      }
      const std::string name = format_stamp(time_ns(i)) + ".pcd";
      EXPECT_TRUE(write_pcd_binary(folder_ / "scans" / name, points, IfExists::kReplace));
    }
    std::vector<PoseRow> rows;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      PoseRow& row = rows.emplace_back();
      row.stamp_ns = time_ns(i) + static_cast<std::int64_t>(1e9 * poses_late_s);
      row.T_world_vehicle = poses[i];
    }
    EXPECT_TRUE(write_tum(folder_ / "poses.tum", rows, IfExists::kReplace));
    RecordingOptions options;
    options.scans = (folder_ / "scans").string();
    options.poses = (folder_ / "poses.tum").string();
    return value_of(open_recording(options));
  }
  static std::int64_t time_ns(std::size_t step) {
    return 1'600'000'000'000'000'000 + static_cast<std::int64_t>(step) * 100'000'000;
  }
  ScratchFolder folder_;
};

TEST_F(CheckPoseClockTest, NamesTheShiftOfPosesThatAreLateOrEarly) {
  const Error late = failure_of(check_pose_clock(record(true, 18.0)));
  EXPECT_EQ(late.code, ErrorCode::kMismatchedInputs);
  EXPECT_THAT(late.message, HasSubstr("18.0 s ahead of that of the scans"));
  EXPECT_THAT(failure_of(check_pose_clock(record(true, -3.0))).message,
              HasSubstr("3.0 s behind that of the scans"));
}

TEST_F(CheckPoseClockTest, AcceptsPosesOfTheScansClockAndEvenMotionAtAnyTime) {
  EXPECT_TRUE(check_pose_clock(record(true, 0.0)).has_value());
  EXPECT_TRUE(check_pose_clock(record(true, 0.05)).has_value());
  EXPECT_TRUE(check_pose_clock(record(false, 18.0)).has_value()) << "straight on";
}

}  // namespace
}  // namespace sightline

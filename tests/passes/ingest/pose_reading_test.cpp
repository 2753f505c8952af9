#include "passes/ingest/pose_reading.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <string>

#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/text/pose_file.h"
#include "passes/ingest/ingest.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/box_world.h"
#include "tests/support/value_of.h"

// Poses whose quaternions begin with w, and times in milliseconds.

namespace sightline {
namespace {

using testing::HasSubstr;

class PoseReading : public testing::Test {
 protected:
  // A drive of six scans that heads `heading_rad` and turns a little.
  explicit PoseReading(double heading_rad = 0.0, double turn_rad = 0.05) {
    const BoxWorld world = random_street(2);
    Pose T_vehicle_lidar = Pose::Identity();
    T_vehicle_lidar.translation().z() = 1.8;
    for (int i = 0; i < 6; ++i) {
      const Pose T_street_vehicle = pose_at(1.5 * i, 0.0, turn_rad * i);
      poses_.push_back(pose_at(0.0, 0.0, heading_rad) * T_street_vehicle);
      const Scan scan = scan_world(world, T_street_vehicle * T_vehicle_lidar, 0.5);
      std::vector<PointXyzi> points;
      for (const Eigen::Vector3d& point_m : scan.points_m) {
        const Eigen::Vector3f p = point_m.cast<float>();
        points.push_back({p.x(), p.y(), p.z(), 0.0F});
      }
      const auto file = folder_.path() / "scans" / (std::to_string(i) + ".pcd");
      EXPECT_TRUE(write_pcd_binary(file, points).has_value());
    }
  }
  // The drive that a pose file with this order of columns and this step of times makes.
  Result<Drive> ingested(bool w_first, double step = 0.1) {
    std::string text;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      const Eigen::Quaterniond q(poses_[i].linear());
      const Eigen::Vector3d p_m = poses_[i].translation();
      const auto number = [](double value) { return " " + std::to_string(value); };
      const std::string xyz = number(q.x()) + number(q.y()) + number(q.z());
      const double time = step * static_cast<double>(i);
      text += step < 1.0 ? std::to_string(time) : std::to_string(std::lround(time));
      text += number(p_m.x()) + number(p_m.y()) + number(p_m.z());
      text += (w_first ? number(q.w()) + xyz : xyz + number(q.w())) + "\n";
    }
    RecordingOptions options;
    options.scans = (folder_.path() / "scans").string();
    options.rings = 24;  // those of scan_world
    options.lowest_beam_deg = -20.0;
    options.poses = folder_.write("poses.tum", text).string();
    const Result<Recording> recording = open_recording(options, 1);
    if (!recording) return recording.error();
    PassContext ctx;
    ctx.warning_sink = [this](const std::string& message) { warnings_ += message + "\n"; };
    return ingest(ctx, {}, *recording);
  }
  void expect_the_poses(const Drive& drive) const {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      EXPECT_TRUE(drive.scans[i].T_world_vehicle->isApprox(poses_[i], 1e-4)) << i;
    }
  }

  ScratchFolder folder_;
  std::vector<Pose> poses_;
  std::string warnings_;
};

class PoseReadingWestward : public PoseReading {
 protected:
  PoseReadingWestward() : PoseReading(3.0) {}
};

class PoseReadingStraight : public PoseReading {
 protected:
  PoseReadingStraight() : PoseReading(0.0, 0.0) {}
};

TEST_F(PoseReading, TakesQuaternionsThatBeginWithWWhereTheScansSaySoAndNamesThem) {
  const Drive drive = value_of(ingested(true));
  expect_the_poses(drive);
  EXPECT_THAT(warnings_, HasSubstr("they are read as w x y z"));
}

TEST_F(PoseReadingWestward, TakesThemOfAnyHeading) {
  const Drive drive = value_of(ingested(true));
  expect_the_poses(drive);
  EXPECT_THAT(warnings_, HasSubstr("they are read as w x y z"));
}

// Upside down, a straight drive lays its scans on each other as well.
TEST_F(PoseReadingStraight, TakesThemWhereTheGroundWouldBeOverhead) {
  const Drive drive = value_of(ingested(true));
  expect_the_poses(drive);
  EXPECT_THAT(warnings_, HasSubstr("they are read as w x y z"));
}

TEST_F(PoseReadingStraight, LeavesThemWhereTheGroundIsBelow) {
  const Drive drive = value_of(ingested(false));
  expect_the_poses(drive);
  EXPECT_EQ(warnings_, "");
}

TEST_F(PoseReading, LeavesQuaternionsThatEndWithW) {
  const Drive drive = value_of(ingested(false));
  expect_the_poses(drive);
  EXPECT_EQ(warnings_, "");
}

TEST_F(PoseReadingWestward, LeavesThemOfAnyHeading) {
  const Drive drive = value_of(ingested(false));
  expect_the_poses(drive);
  EXPECT_EQ(warnings_, "");
}

TEST_F(PoseReading, TakesTimesInMillisecondsAndNamesThem) {
  const Drive drive = value_of(ingested(false, 100.0));
  EXPECT_EQ(drive.scans[5].stamp_ns, 500'000'000);
  EXPECT_THAT(warnings_, HasSubstr("they are read as milliseconds"));
}

}  // namespace
}  // namespace sightline

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
#include "tests/support/test_context.h"

// Poses whose quaternions begin with w, and times in milliseconds.

namespace sightline {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

// A drive of six scans that heads `heading_rad` and turns a little.
class RecordedDrive {
 public:
  explicit RecordedDrive(double heading_rad = 0.0, double turn_rad = 0.05) {
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
  Drive ingested(bool w_first, double step = 0.1) {
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
    return value_of(ingest(ctx_, {}, value_of(open_recording(options, 1))));
  }
  void expect_the_poses(const Drive& drive) const {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      EXPECT_TRUE(drive.scans[i].T_world_vehicle->isApprox(poses_[i], 1e-4)) << i;
    }
  }

  [[nodiscard]] const std::vector<std::string>& warnings() const { return ctx_.warnings; }

 private:
  ScratchFolder folder_;
  std::vector<Pose> poses_;
  TestContext ctx_;
};

struct Way {
  double heading_rad = 0.0;
  double turn_rad = 0.05;
};
// Upside down, a straight drive lays its scans on each other as well: then the ground decides.
const Way kWays[] = {{}, {.heading_rad = 3.0}, {.turn_rad = 0.0}};

TEST(PoseReading, TakesQuaternionsThatBeginWithWWhereTheScansSaySoAndNamesThem) {
  for (const Way& way : kWays) {
    RecordedDrive recorded(way.heading_rad, way.turn_rad);
    recorded.expect_the_poses(recorded.ingested(true));
    EXPECT_THAT(recorded.warnings(), Contains(HasSubstr("are read as w x y z")));
  }
}

TEST(PoseReading, LeavesQuaternionsThatEndWithW) {
  for (const Way& way : kWays) {
    RecordedDrive recorded(way.heading_rad, way.turn_rad);
    recorded.expect_the_poses(recorded.ingested(false));
    EXPECT_THAT(recorded.warnings(), IsEmpty());
  }
}

TEST(PoseReading, TakesTimesInMillisecondsAndNamesThem) {
  RecordedDrive recorded;
  EXPECT_EQ(recorded.ingested(false, 100.0).scans[5].stamp_ns, 500'000'000);
  EXPECT_THAT(recorded.warnings(), Contains(HasSubstr("they are read as milliseconds")));
}

}  // namespace
}  // namespace sightline

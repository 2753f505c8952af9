#include "passes/ingest/check_upright.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "formats/base/random.h"
#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/foreign/recording/open_recording.h"
#include "passes/ingest/ingest.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

// Four scans of a street: ground 1.8 m below the sensor, and two walls.
class CheckUprightTest : public testing::Test {
 protected:
  enum class Place { kStreet, kCarPark };

  Recording record(Place place, bool is_negated, double roll_deg) {
    Random random(5);
    for (int scan = 0; scan < 4; ++scan) {
      std::vector<PointXyzi> points;
      const auto add = [&](double x_m, double y_m, double z_m) {
        points.push_back({static_cast<float>(x_m), static_cast<float>(y_m),
                          static_cast<float>(is_negated ? -z_m : z_m), 0.0F});
      };
      for (int i = 0; i < 600; ++i) {
        add(random.uniform(-15.0, 15.0), random.uniform(-7.0, 7.0), -1.8);
        add(random.uniform(-15.0, 15.0), i % 2 == 0 ? 8.0 : -8.0, random.uniform(-1.7, 5.0));
        if (place == Place::kStreet) continue;
        add(random.uniform(-15.0, 15.0), random.uniform(-7.0, 7.0), 0.8);
        add(random.uniform(-15.0, 15.0), random.uniform(-7.0, 7.0), 0.85);
      }
      write(scan, points);
    }
    RecordingOptions options;
    options.scans = folder_.path().string();
    options.lidar_roll_deg = roll_deg;
    return value_of(open_recording(options));
  }
  void write(int scan, const std::vector<PointXyzi>& points) {
    EXPECT_TRUE(
        write_pcd_binary(folder_ / concat(scan, ".pcd"), points, IfExists::kReplace).has_value());
  }
  static Drive drive_of(const Recording& recording) {
    Drive drive;
    drive.sensor = recording.sensor;
    drive.scans.resize(recording.scans.size());
    return drive;
  }
  static Result<void> check(const Recording& recording) {
    return check_upright(recording, drive_of(recording));
  }
  ScratchFolder folder_;
};

TEST_F(CheckUprightTest, RefusesScansWhoseGroundIsAboveTheSensor) {
  const Error refused = failure_of(check(record(Place::kStreet, true, 0.0)));
  EXPECT_EQ(refused.code, ErrorCode::kUnsupportedFormat);
  EXPECT_THAT(refused.message, HasSubstr("the ground is 1.7 m above the sensor in 4 of 4 scans"));
  EXPECT_EQ(code_of(ingest(TestContext(), {}, record(Place::kStreet, true, 0.0))),
            ErrorCode::kUnsupportedFormat);
}

TEST_F(CheckUprightTest, AcceptsTheGroundBelowTheSensorInItsMountingOrByItsPoses) {
  EXPECT_TRUE(check(record(Place::kStreet, false, 0.0)).has_value());
  const Recording turned = record(Place::kStreet, true, 180.0);
  EXPECT_TRUE(check(turned).has_value());
  const Recording posed = record(Place::kStreet, true, 0.0);
  Drive drive = drive_of(posed);
  for (ScanInfo& scan : drive.scans) {
    scan.T_world_vehicle = Pose::Identity();
    scan.T_world_vehicle->rotate(rotation_matrix({Eigen::Vector3d::UnitX(), std::numbers::pi}));
  }
  EXPECT_TRUE(check_upright(posed, drive).has_value());
}

TEST_F(CheckUprightTest, AcceptsACeiling) {
  EXPECT_TRUE(check(record(Place::kCarPark, false, 0.0)).has_value());
}

}  // namespace
}  // namespace sightline

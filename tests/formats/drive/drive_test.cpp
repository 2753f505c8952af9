#include "formats/drive/drive.h"

#include "tests/support/artifact_checks.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

Drive two_scans() {
  Drive drive;
  drive.name = "loop, first";
  drive.sensor.beam_elevations_deg = {-1.0, 1.0};
  drive.frame.origin_world_m = Eigen::Vector3d(588288.0, 4141184.0, -64.0);
  for (std::uint32_t i = 0; i < 2; ++i) {
    ScanInfo& scan = drive.scans.emplace_back();
    scan.recording_index = i;
    scan.stamp_ns = 1'567'410'201'745'204'700 + static_cast<std::int64_t>(i);
    scan.source = i == 0 ? "000000.pcd" : "000001.pcd";
    scan.point_count = 10 + i;
    scan.nonfinite_count = 2;
    scan.zero_count = 3;
    scan.T_world_vehicle = Pose::Identity();
    scan.T_world_vehicle->translation() = Eigen::Vector3d(588348.947978, 4141240.223859, i);
  }
  return drive;
}

TEST(Drive, SurvivesDiskWithAndWithoutPoses) {
  Drive drive = two_scans();
  EXPECT_TRUE(drive.has_poses());
  expect_survives_disk(drive);
  drive.scans[1].T_world_vehicle.reset();
  EXPECT_FALSE(drive.has_poses());
  expect_survives_disk(drive);
  EXPECT_FALSE(Drive{}.has_poses());
}

TEST(Drive, GetsItsScansBackAfterDisk) {
  const Drive decoded = value_of(from_bytes<Drive>(to_bytes(two_scans())));
  EXPECT_EQ(decoded.store, nullptr);
  Scan scan;
  scan.stamp_ns = 7;
  scan.points_m = {Eigen::Vector3d(1, 2, 3)};
  const Scan read = value_of(with_store(decoded, memory_scan_store({Scan{}, scan})).store->read(1));
  EXPECT_EQ(read.stamp_ns, 7);
  EXPECT_EQ(read.points_m, scan.points_m);
}

TEST(Drive, TellsWhichOfItsSensorsMadeAScan) {
  Drive drive = two_scans();
  drive.other_sensors.push_back(*sensor_profile("vlp-16"));
  drive.other_sensors[0].T_vehicle_lidar.translation().x() = -1.5;
  drive.scans[1].sensor_index = 1;
  drive.scans[1].has_point_times = true;
  EXPECT_EQ(&drive.sensor_of(drive.scans[0]), &drive.sensor);
  EXPECT_EQ(&drive.sensor_of(drive.scans[1]), &drive.other_sensors[0]);
  expect_survives_disk(drive);
  drive.scans[1].stamp_ns = drive.scans[0].stamp_ns;
  EXPECT_TRUE(validate(drive).has_value());
  std::swap(drive.scans[0].sensor_index, drive.scans[1].sensor_index);
  EXPECT_EQ(validate(drive).error().code, ErrorCode::kTimeRunsBackwards);
  drive = two_scans();
  drive.scans[1].sensor_index = 1;
  EXPECT_EQ(validate(drive).error().code, ErrorCode::kInvalidArtifact);
}

TEST(Drive, EvenAndOddScansAreToldByTheirPlaceInTheRecording) {
  ScanInfo scan;
  for (std::uint32_t i = 0; i < 6; ++i) {
    scan.recording_index = i;
    EXPECT_TRUE(is_selected(scan, ScanSelection::kAll));
    EXPECT_EQ(is_selected(scan, ScanSelection::kEven), i % 2 == 0);
    EXPECT_EQ(is_selected(scan, ScanSelection::kOdd), i % 2 == 1);
  }
}

TEST(Drive, KeepsTurnRatesAndHasTheBytesOfBeforeWithoutThem) {
  Drive drive = two_scans();
  const std::vector<std::byte> without = to_bytes(drive);
  drive.turn_rates = {{7, Eigen::Vector3d(0.1, 0.2, 0.3)}, {9, Eigen::Vector3d(-1.0, 0.0, 1e-9)}};
  expect_survives_disk(drive);
  const Drive decoded = value_of(from_bytes<Drive>(to_bytes(drive)));
  ASSERT_EQ(decoded.turn_rates.size(), 2U);
  EXPECT_EQ(decoded.turn_rates[1].stamp_ns, 9);
  EXPECT_EQ(decoded.turn_rates[1].rate_rad_per_s, drive.turn_rates[1].rate_rad_per_s);
  drive.turn_rates.clear();
  drive.specific_forces = {{7, Eigen::Vector3d(0.1, 0.2, 9.8)}};
  drive.wheel_speeds = {{7, 3.5}, {8, -0.5}};
  expect_survives_disk(drive);
  EXPECT_EQ(from_bytes<Drive>(to_bytes(drive))->wheel_speeds[1].speed_m_s, -0.5);
  drive.specific_forces.clear();
  drive.wheel_speeds.clear();
  EXPECT_EQ(to_bytes(drive), without);
  EXPECT_TRUE(from_bytes<Drive>(without)->turn_rates.empty());
}

TEST(Drive, RefusesTurnRatesThatDoNotAdvanceOrAreNotFinite) {
  Drive drive = two_scans();
  drive.turn_rates = {{7, Eigen::Vector3d::Zero()}, {7, Eigen::Vector3d::Zero()}};
  EXPECT_EQ(validate(drive).error().code, ErrorCode::kTimeRunsBackwards);
  EXPECT_EQ(validate(drive).error().place, "turn rate 1");
  drive.turn_rates[1].stamp_ns = 8;
  EXPECT_TRUE(validate(drive).has_value());
  drive.turn_rates[1].rate_rad_per_s.y() = std::nan("");
  EXPECT_EQ(validate(drive).error().code, ErrorCode::kInvalidArtifact);
}

TEST(Drive, RefusesSpeedsAndForcesThatDoNotAdvanceOrAreNotFinite) {
  Drive drive = two_scans();
  drive.wheel_speeds = {{7, 1.0}, {7, 1.0}};
  EXPECT_EQ(validate(drive).error().code, ErrorCode::kTimeRunsBackwards);
  EXPECT_EQ(validate(drive).error().place, "wheel speed 1");
  drive.wheel_speeds = {{7, std::nan("")}};
  EXPECT_EQ(validate(drive).error().code, ErrorCode::kInvalidArtifact);
  drive.wheel_speeds.clear();
  drive.specific_forces = {{7, Eigen::Vector3d(0.0, std::nan(""), 0.0)}};
  EXPECT_EQ(validate(drive).error().place, "specific force 0");
}

TEST(Drive, RefusesTimesThatDoNotAdvanceAndPosesThatAreNone) {
  Drive drive = two_scans();
  drive.scans[1].stamp_ns = drive.scans[0].stamp_ns;
  EXPECT_EQ(validate(drive).error().code, ErrorCode::kTimeRunsBackwards);
  EXPECT_EQ(validate(drive).error().place, "scan 1");
  expect_refused<Drive>(two_scans(),
                        {[](Drive& changed) { changed.scans[1].recording_index = 0; },
                         [](Drive& changed) { changed.scans[0].T_world_vehicle->linear() *= 1.1; },
                         [](Drive& changed) { changed.sensor.beam_elevations_deg.clear(); }});
}

}  // namespace
}  // namespace sightline

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>

#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/recording/open_recording.h"
#include "passes/ingest/ingest.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "tests/support/box_world.h"
#include "tests/support/real_data.h"
#include "tests/support/test_context.h"

// estimate-trajectory on longer ways: a round trip, and a real recording where there is one.

namespace sightline {
namespace {

using testing::Contains;
using testing::HasSubstr;

BoxWorld round_world(double radius_m) {
  Random random(11);
  BoxWorld world;
  for (int i = 0; i < 40; ++i) {
    for (const double off_m : {-7.0, 8.0}) {
      const double angle_rad = 2.0 * std::numbers::pi * i / 40.0;
      const double reach_m = radius_m + off_m + random.uniform(-1.0, 1.0);
      const Eigen::Vector3d centre_m(reach_m * std::sin(angle_rad),
                                     radius_m - reach_m * std::cos(angle_rad), 0.0);
      const double half_m = random.uniform(0.3, 1.5);
      world.boxes.push_back({centre_m - Eigen::Vector3d(half_m, half_m, 0.0),
                             centre_m + Eigen::Vector3d(half_m, half_m, random.uniform(2.0, 6.0))});
    }
  }
  return world;
}

TEST(EstimateTrajectorySlow, ClosesTheLoopOfARoundTrip) {
  constexpr double kRadius_m = 20.0;
  constexpr int kScansARound = 110;
  std::vector<Pose> poses;
  for (int i = 0; i < kScansARound + 10; ++i) {
    const double angle_rad = 2.0 * std::numbers::pi * i / kScansARound;
    poses.push_back(pose_at(kRadius_m * std::sin(angle_rad),
                            kRadius_m * (1.0 - std::cos(angle_rad)), angle_rad));
  }
  const TestDrive test = drive_through(round_world(kRadius_m), poses, 0.5);
  const Trajectory closed = value_of(estimate_trajectory(TestContext(2), {}, test.drive));
  EXPECT_GE(closed.loop_edges, 2u);
  const Eigen::Vector3d end_m = closed.poses.back().T_map_vehicle.translation();
  EXPECT_LT((end_m - poses.back().translation()).norm(), 0.1);
  EXPECT_LT(closed.rms_translation_residual_m, 0.05);
}

// Without scans where one of the files cannot be read.
Drive drive_of_files(const std::vector<std::filesystem::path>& files,
                     const std::vector<std::int64_t>& stamps_ns, const std::string& sensor) {
  std::vector<Scan> scans(files.size());
  Drive drive;
  drive.name = "on";
  drive.sensor = *sensor_profile(sensor);
  for (std::uint32_t i = 0; i < files.size(); ++i) {
    const Result<PointCloudFile> cloud = read_point_cloud(files[i]);
    if (!cloud) return {};
    scans[i].stamp_ns = stamps_ns[i];
    scans[i].points_m = cloud->points_m;
    ScanInfo info;
    info.recording_index = i;
    info.stamp_ns = scans[i].stamp_ns;
    drive.scans.push_back(info);
  }
  drive.store = memory_scan_store(std::move(scans));
  return drive;
}

// At 10 Hz.
Drive drive_of_files(const std::vector<std::filesystem::path>& files, const std::string& sensor) {
  std::vector<std::int64_t> stamps_ns;
  for (std::size_t i = 0; i < files.size(); ++i) {
    stamps_ns.push_back(static_cast<std::int64_t>(i) * 100'000'000);
  }
  return drive_of_files(files, stamps_ns, sensor);
}

std::vector<std::filesystem::path> numbered(const std::filesystem::path& folder, std::size_t count,
                                            std::size_t digits) {
  std::vector<std::filesystem::path> files;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string number = std::to_string(i);
    files.push_back(folder / (std::string(digits - number.size(), '0') + number + ".pcd"));
  }
  return files;
}

// The 154th scan relative to the first by another program's quick ICP; good to some cm.
TEST(EstimateTrajectorySlow, EndsWhereIcpEndsOnARealStreet) {
  const RealData data = real_data("kitti_0005");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  const Drive drive = drive_of_files(numbered(data.folder, 154, 10), "hdl-64e");
  ASSERT_FALSE(drive.scans.empty())
      << "a scan of " << data.folder << " is missing or cannot be read";
  const Trajectory trajectory = value_of(estimate_trajectory(TestContext(2), {}, drive));
  const Eigen::Vector3d icp_end_m(63.888, 9.363, -0.508);
  EXPECT_LT((trajectory.poses.back().T_map_vehicle.translation() - icp_end_m).norm(), 0.3);
}

// A street once more, its scans in reverse: a sensor that turns in the other direction, with its
// points in the order in which they were measured. No timing is right, so loops between the drives
// contradict each other.
TEST(EstimateTrajectorySlow, WarnsWhereLoopsContradictOnARealStreet) {
  const RealData data = real_data("pandar128_street");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  const std::vector<std::filesystem::path> files =
      numbered(data.folder / "pandar128_street" / "lidar", 44, 6);
  std::vector<std::filesystem::path> both = files;
  both.insert(both.end(), files.rbegin(), files.rend());
  for (const bool turns_back : {false, true}) {
    Drive drive = drive_of_files(turns_back ? both : files, "vls-128");
    ASSERT_FALSE(drive.scans.empty()) << "a scan of " << data.folder << " cannot be read";
    if (turns_back) {
      drive.later_parts = {"back"};
      for (std::size_t i = files.size(); i < both.size(); ++i) drive.scans[i].part = 1;
    }
    TestContext ctx(2);
    require(estimate_trajectory(ctx, {}, drive));
    const bool contradicts = testing::Matches(
        Contains(HasSubstr("loop closures contradict the trajectory: drive back")))(ctx.warnings);
    EXPECT_EQ(contradicts, turns_back) << testing::PrintToString(ctx.warnings);
  }
}

// Official poses that start wrong: 0.86 m a scan where the scans show 0.69 m.
TEST(EstimateTrajectorySlow, NoticesThatTheFirstPosesOfAWellKnownRecordingAreWrong) {
  const RealData data = real_data("kitti00_head");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  RecordingOptions options;
  options.scans = data.folder / "data";
  options.poses = data.folder / "KITTI_00_gt_velodyne_frame.txt";
  options.poses_of = PosesOf::kSensor;
  options.sensor = "hdl-64e";
  const Recording recording = value_of(open_recording(options, 2));
  TestContext ctx(2);
  const Drive drive = value_of(ingest(ctx, {}, recording));
  EstimateTrajectoryOptions repair;
  repair.bad_poses = BadPoses::kRepair;
  const Trajectory trajectory = value_of(estimate_trajectory(ctx, repair, drive));
  EXPECT_THAT(ctx.warnings, Contains(HasSubstr("given poses and scans disagree on 1 stretches")));
  const double way_m = (trajectory.poses[5].T_map_vehicle.translation() -
                        trajectory.poses[0].T_map_vehicle.translation())
                           .norm();
  EXPECT_NEAR(way_m / 5.0, 0.70, 0.04);  // it speeds up from 0.68 to 0.74 m
}

// Scans [first, last] of a river road between hedges, 2 to 14 m apart, each `every`-th, and where
// somebody's SLAM put their sensor.
struct RiverRoad {
  Drive drive;
  std::vector<Eigen::Vector3d> T_slam_m;
};

std::vector<double> numbers_of(const std::filesystem::path& file) {
  std::ifstream text(file);
  return {std::istream_iterator<double>(text), {}};
}

RiverRoad river_road(const std::filesystem::path& folder, std::size_t first, std::size_t last,
                     std::size_t every) {
  const std::vector<std::filesystem::path> all = numbered(folder / "Scans", last + 1, 6);
  const std::vector<double> times_s = numbers_of(folder / "times.txt");
  const std::vector<double> poses = numbers_of(folder / "optimized_poses.txt");
  RiverRoad road;
  std::vector<std::filesystem::path> files;
  std::vector<std::int64_t> stamps_ns;
  for (std::size_t i = first; i <= last; i += every) {
    files.push_back(all[i]);
    stamps_ns.push_back(std::llround(1e9 * times_s.at(i)));
    const std::size_t row = 12 * i;
    road.T_slam_m.emplace_back(poses.at(row + 3), poses.at(row + 7), poses.at(row + 11));
  }
  road.drive = drive_of_files(files, stamps_ns, "os1-64");
  return road;
}

struct RiverDrive {
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t every = 1;
  std::size_t pieces = 1;
};

// A step within a piece that is not named is that of the SLAM: hedges look alike every few metres,
// so that a drive seems to stand still, or to keep its speed where it brakes.
TEST(EstimateTrajectorySlow, NamesEachWrongStepOnARealRoadBetweenHedges) {
  const RealData data = real_data("mulran_riverside");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  for (const RiverDrive& part :
       {RiverDrive{1, 56}, {25, 56}, {62, 109}, {114, 166}, {114, 166, 2, 3}}) {
    SCOPED_TRACE(part.first);
    const RiverRoad road =
        river_road(data.folder / "mulran_riverside", part.first, part.last, part.every);
    ASSERT_FALSE(road.drive.scans.empty()) << "a scan of " << data.folder << " cannot be read";
    const Trajectory trajectory = value_of(estimate_trajectory(TestContext(2), {}, road.drive));
    const std::vector<TrajectoryPose>& poses = trajectory.poses;
    EXPECT_LE(poses.back().piece + 1, part.pieces);
    std::size_t named = 0;
    for (std::size_t k = 1; k < poses.size(); ++k) {
      if (poses[k].unconstrained.is_any()) ++named;
      if (poses[k].unconstrained.is_any() || poses[k].piece != poses[k - 1].piece) continue;
      const double step_m =
          (poses[k].T_map_vehicle.translation() - poses[k - 1].T_map_vehicle.translation()).norm();
      const double slam_m = (road.T_slam_m[k] - road.T_slam_m[k - 1]).norm();
      EXPECT_NEAR(step_m, slam_m, 0.15 * slam_m) << "step to scan " << k;
    }
    EXPECT_LE(named, 4u) << "scans 31 to 35 hardly meet";
  }
}

}  // namespace
}  // namespace sightline

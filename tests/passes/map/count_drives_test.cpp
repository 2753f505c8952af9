#include "passes/map/count_drives.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

// `count` returns about a place of the map, as a scan that stands at its origin sees them.
Scan scan_of(const Eigen::Vector3d& at_m, int count) {
  Scan scan;
  for (int i = 0; i < count; ++i)
    scan.points_m.push_back(at_m + Eigen::Vector3d(0.0, 0.01 * i, 0.0));
  return scan;
}

struct Seen {
  std::uint32_t part = 0;
  double x_m = 0.0;
  Scan scan;
  bool is_laid = true;
};

struct World {
  Drive drive;
  Trajectory trajectory;
  SurfacePoints points;
};

World world_of(const std::vector<Seen>& seen) {
  World world;
  world.drive.name = "first";
  std::vector<Scan> scans;
  for (std::uint32_t i = 0; i < seen.size(); ++i) {
    while (seen[i].part > world.drive.later_parts.size()) {
      world.drive.later_parts.push_back("later " + std::to_string(world.drive.later_parts.size()));
    }
    ScanInfo info;
    info.stamp_ns = 10 * i;
    info.part = seen[i].part;
    world.drive.scans.push_back(info);
    TrajectoryPose pose;
    pose.T_map_vehicle.translation().x() = seen[i].x_m;
    pose.is_laid = seen[i].is_laid;
    world.trajectory.poses.push_back(pose);
    if (pose.is_laid) {
      world.points.scans.push_back({i, pose.T_map_vehicle, 0.0, 1000.0, seen[i].part});
    }
    scans.push_back(seen[i].scan);
  }
  world.points.store = memory_scan_store(std::move(scans));
  return world;
}

TileDrives must_count(const World& world, const CountDrivesOptions& options, int threads = 1) {
  return value_of(
      count_drives(TestContext(threads), options, world.drive, world.trajectory, world.points));
}

TEST(CountDrives, NamesTheDrivesOfEachTile) {
  const World world = world_of({{0, 0.0, scan_of({5.0, 1.0, 0.0}, 20)},
                                {0, 3.0, scan_of({5.0, 1.0, 0.0}, 10)},
                                {1, 0.0, scan_of({-5.0, 1.0, 0.0}, 10)},
                                {1, 4.0, scan_of({5.0, 1.0, 0.0}, 9)}});
  const TileDrives tiles = must_count(world, {.tile_m = 64.0});
  EXPECT_EQ(tiles.drives, (std::vector<MappedDrive>{{"first", 0, 10}, {"later 0", 20, 30}}));
  EXPECT_EQ(tiles.rows, (std::vector<TileDrive>{{{-1, 0}, 1, 1, 0}, {{0, 0}, 0, 2, 0}}))
      << "nine returns say nothing";
  EXPECT_TRUE(validate(tiles));
}

TEST(CountDrives, LooksAtScansThatLieApart) {
  std::vector<Seen> seen;
  for (int i = 0; i < 9; ++i) seen.push_back({0, 0.5 * i, scan_of({5.0, 1.0, 0.0}, 20)});
  EXPECT_EQ(must_count(world_of(seen), {.step_m = 2.0}).rows[0].scan_count, 3U) << "0, 2 and 4 m";
  EXPECT_EQ(must_count(world_of(seen), {.step_m = 0.0}).rows[0].scan_count, 9U);
}

TEST(CountDrives, NamesTheDrivesThatFoundNothingNew) {
  std::vector<Seen> seen = {{0, 0.0, scan_of({5.0, 1.0, 0.0}, 20)}};
  for (int i = 0; i < 40; ++i) {
    const double x_m = 44.0 + i;  // 20 m in the first tile, 20 m in the second
    seen.push_back({1, x_m, scan_of({-30.0, 0.0, 0.0}, 20), i >= 30});
  }
  const TileDrives tiles = must_count(world_of(seen), {.tile_m = 64.0, .step_m = 2.0});
  EXPECT_EQ(tiles.rows,
            (std::vector<TileDrive>{{{0, 0}, 0, 1, 0}, {{0, 0}, 1, 5, 10}, {{1, 0}, 1, 0, 5}}));
}

TEST(CountDrives, DoesNotCountWhatMoved) {
  World world = world_of({{0, 0.0, scan_of({5.0, 1.0, 0.0}, 10)}});
  world.points.voxel_m = 1.0;
  world.points.moved_voxels = {{5, 1, 0}};
  EXPECT_TRUE(must_count(world, {}).rows.empty());
}

TEST(CountDrives, GivesTheSameForAnyNumberOfThreadsAndDrivesInAnyOtherPlace) {
  Random random(5);
  std::vector<Seen> seen;
  for (std::uint32_t part = 0; part < 4; ++part) {
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d at_m(random.uniform(-200.0, 200.0), random.uniform(-200.0, 200.0), 0.0);
      seen.push_back({part, 3.0 * i, scan_of(at_m, 15)});
    }
  }
  const TileDrives tiles = must_count(world_of(seen), {});
  EXPECT_EQ(must_count(world_of(seen), {}, 7), tiles);
  EXPECT_TRUE(validate(tiles));
  std::uint32_t scans = 0;
  for (const TileDrive& row : tiles.rows) scans += row.scan_count;
  EXPECT_GE(scans, 24U) << "every scan left its mark somewhere";
}

TEST(CountDrives, RefusesPointsOfAnotherDrive) {
  World world = world_of({{0, 0.0, scan_of({5.0, 1.0, 0.0}, 10)}});
  world.points.scans[0].part = 1;
  EXPECT_EQ(
      count_drives(TestContext(), {}, world.drive, world.trajectory, world.points).error().code,
      ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline

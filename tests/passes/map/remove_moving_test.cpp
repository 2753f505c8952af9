#include "passes/map/remove_moving.h"

#include <gtest/gtest.h>
#include <algorithm>

#include "passes/map/tile_carver.h"
#include "tests/support/box_world.h"
#include "tests/support/kept_parts.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

SurfacePoints remove(const TestDrive& test, const RemoveMovingOptions& options = {},
                     int threads = 1) {
  return value_of(remove_moving(TestContext(threads), options, test.drive, test.truth));
}

std::vector<Eigen::Vector3d> points_of(const SurfacePoints& points, bool wants_moving) {
  const SurfacePointReader reader(points);
  std::vector<Eigen::Vector3d> all_m;
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    const std::vector<Eigen::Vector3d> part_m =
        value_of(wants_moving ? reader.moving(part) : reader.standing(part));
    all_m.insert(all_m.end(), part_m.begin(), part_m.end());
  }
  return all_m;
}

// A sensor that stands at 2 m above (0,0,0). Something was 5 m ahead in the first `hits` scans; in
// the others the wall behind it is seen through its place. The ground below it is always seen.
TestDrive crossing(int hits, int misses) {
  const Eigen::Vector3d thing(5.1, 0.1, -0.9);
  std::vector<Scan> scans;
  for (int i = 0; i < hits + misses; ++i) {
    Scan scan;
    scan.points_m.push_back(i < hits ? thing : 2.0 * thing);
    scan.points_m.push_back({5.1, 0.1, -2.0});
    scans.push_back(scan);
  }
  const std::vector<Pose> poses(scans.size(), Pose::Identity());
  return drive_of(std::move(scans), poses);
}

// The sensor's model: a hit is worth log(0.7/0.3) = 0.847, a miss log(0.4/0.6) = -0.405.
TEST(RemoveMoving, TakesThreeMissesToOutweighAHit) {
  EXPECT_EQ(remove(crossing(1, 2)).moving_count, 0u);
  const TestDrive test = crossing(1, 3);
  const SurfacePoints points = remove(test);
  EXPECT_EQ(points.moved_voxels, (std::vector<CellKey>{{25, 0, 5}}));
  ASSERT_EQ(points_of(points, true).size(), 1u);
  EXPECT_LT((points_of(points, true)[0] - Eigen::Vector3d(5.1, 0.1, 1.1)).norm(), 1e-12);
  EXPECT_EQ(points_of(points, false).size(), 7u);
  EXPECT_EQ(points.standing_count, 7u);
  EXPECT_EQ(remove(crossing(2, 4)).moving_count, 0u);
  EXPECT_EQ(remove(crossing(2, 5)).moving_count, 2u);
}

TEST(RemoveMoving, LooksNoFartherThanTheCarveRange) {
  RemoveMovingOptions options{.carve_range_m = 5.0};
  EXPECT_EQ(remove(crossing(1, 9), options).moving_count, 0u);
  options.carve_range_m = 6.0;
  EXPECT_EQ(remove(crossing(1, 9), options).moving_count, 1u);
}

TEST(RemoveMoving, LooksAnewOnlyIntoTilesThatAChangeReaches) {
  TestDrive test = crossing(2, 5);
  KeptParts kept;
  const auto run = [&] {
    PassContext ctx = kept.context();
    return to_bytes(*remove_moving(ctx, {}, test.drive, test.truth));
  };
  (void)run();
  const std::size_t near_parts = kept.count();
  EXPECT_EQ(kept.made().size(), near_parts);
  std::vector<Scan> scans = scans_of(test.drive);
  std::vector<Pose> poses(7, Pose::Identity());
  scans.push_back(scans.back());
  poses.push_back(pose_at(1000.0, 0.0, 0.0));
  test = drive_of(scans, poses);
  const std::vector<std::byte> more = run();
  EXPECT_EQ(kept.count(), 2 * near_parts) << "the tiles of both";
  EXPECT_EQ(kept.made().size(), near_parts) << "the tiles far away";
  kept.forget();
  EXPECT_EQ(run(), more);
}

TEST(RemoveMoving, KeepsEverythingWhenItIsOff) {
  const RemoveMovingOptions options{.enabled = false};
  const SurfacePoints points = remove(crossing(1, 9), options);
  EXPECT_EQ(points_of(points, false).size(), 20u);
  EXPECT_EQ(points.standing_count, 20u);
  EXPECT_EQ(points.voxel_m, 0.0);
}

TEST(RemoveMoving, UsesTheScansThatAreAskedForAndCountsWhatIsOutOfRange) {
  TestDrive test = crossing(1, 4);
  test.drive.sensor.max_range_m = 6.0;  // the wall behind is farther
  const RemoveMovingOptions options{.scans = ScanSelection::kOdd};
  const SurfacePoints points = remove(test, options);
  EXPECT_EQ(points.standing_count, 2u);
  EXPECT_EQ(points.out_of_range_count, 2u);
}

TEST(RemoveMoving, LeavesAloneWhatEveryScanSeesStanding) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const std::vector<Pose> poses(3, pose_at(0.0, 0.0, 0.1 * static_cast<double>(seed)));
    const SurfacePoints points = remove(drive_through(random_street(seed), poses));
    ASSERT_EQ(points.moving_count, 0u) << "street " << seed;
  }
}

TEST(RemoveMoving, KeepsAStreetThatItDrivesThrough) {
  for (std::uint64_t seed = 0; seed < 2; ++seed) {
    std::vector<Pose> poses;
    for (int i = 0; i < 12; ++i) poses.push_back(pose_at(i, 0.0, 0.0));
    const SurfacePoints points = remove(drive_through(random_street(seed), poses));
    ASSERT_LT(points.moving_count, points.standing_count / 500) << "street " << seed;
  }
}

// A street that we drive through at 5 m/s, rays `azimuth_step_deg` apart; a car of 4 m comes
// towards us on the other lane, at 10 m/s.
TestDrive street_with_car(int scan_count, double azimuth_step_deg) {
  std::vector<Scan> scans;
  std::vector<Pose> poses;
  for (int i = 0; i < scan_count; ++i) {
    BoxWorld world = random_street(1);
    world.boxes.push_back({{25.0 - i, 2.0, 0.25}, {29.0 - i, 3.8, 1.6}});
    poses.push_back(pose_at(0.5 * i, 0.0, 0.0));
    scans.push_back(scan_world(world, lidar_at(0.5 * i, 0.0, 0.0), azimuth_step_deg));
  }
  return drive_of(std::move(scans), poses);
}

TEST(RemoveMoving, TakesOutACarThatPassesAndNothingElse) {
  const TestDrive test = street_with_car(30, 2.0);
  const RemoveMovingOptions options{.carve_range_m = 30.0};
  const SurfacePoints points = remove(test, options);
  const auto is_on_lane = [](const Eigen::Vector3d& p) {
    return p.z() > 0.2 && p.y() > 1.9 && p.y() < 3.9;
  };
  const auto left = std::ranges::count_if(points_of(points, false), is_on_lane);
  const auto taken = std::ranges::count_if(points_of(points, true), is_on_lane);
  EXPECT_GT(taken, 250);
  EXPECT_LT(left, taken / 20);
  EXPECT_LT(points.moving_count - static_cast<std::uint64_t>(taken), points.standing_count / 500);
}

std::vector<PlacedScan> placed(const TestDrive& test) {
  std::vector<PlacedScan> scans;
  for (std::uint32_t i = 0; i < test.drive.scans.size(); ++i) {
    const Pose T_map_lidar = test.truth.poses[i].T_map_vehicle * test.drive.sensor.T_vehicle_lidar;
    scans.push_back({i, T_map_lidar, 0.5, 100.0});
  }
  return scans;
}

std::vector<CellKey> found_by_tiles_of(double tile_m, const TestDrive& test) {
  CarveOptions options{.carve_range_m = 15.0};
  options.tile_m = tile_m;
  const std::vector<PlacedScan> scans = placed(test);
  std::vector<CellKey> moved;
  for (const TileKey& tile : tiles_to_look_at(options, scans)) {
    const TileFindings found =
        value_of(find_moving_in_tile(options, *test.drive.store, scans, tile));
    moved.insert(moved.end(), found.moved_voxels.begin(), found.moved_voxels.end());
  }
  std::ranges::sort(moved);
  return moved;
}

TEST(RemoveMoving, FindsTheSameWhereverTilesBegin) {
  const TestDrive test = street_with_car(14, 4.0);
  const std::vector<CellKey> whole = found_by_tiles_of(1000.0, test);
  EXPECT_GT(whole.size(), 20u);  // there is something to find
  EXPECT_EQ(found_by_tiles_of(18.3, test), whole);
}

TEST(RemoveMoving, GivesTheSameBytesForAnyNumberOfThreads) {
  const TestDrive test = drive_through(
      random_street(9), {pose_at(0.0, 0.0, 0.0), pose_at(1.0, 0.0, 0.0), pose_at(2.0, 0.0, 0.1)});
  const std::vector<std::byte> one = to_bytes(remove(test, {}, 1));
  EXPECT_EQ(to_bytes(remove(test, {}, 2)), one);
  EXPECT_EQ(to_bytes(remove(test, {}, 5)), one);
}

ErrorCode error_of(const TestDrive& test, const RemoveMovingOptions& options = {}) {
  return failure_of(remove_moving(TestContext(), options, test.drive, test.truth)).code;
}

class BrokenStore : public ScanStore {
 public:
  Result<Scan> read(std::size_t) const override {
    return Error{ErrorCode::kTruncatedScan, "cut short", "000000.pcd", "byte 12"};
  }
};

TEST(RemoveMoving, RefusesBadInput) {
  TestDrive other = crossing(1, 1);
  other.truth.poses.pop_back();
  EXPECT_EQ(error_of(other), ErrorCode::kMismatchedInputs);
  const RemoveMovingOptions odd{.scans = ScanSelection::kOdd};
  EXPECT_EQ(error_of(crossing(1, 0), odd), ErrorCode::kDriveTooShort);
  TestDrive far = crossing(1, 1);
  far.drive.sensor.max_range_m = 1.5;
  EXPECT_EQ(error_of(far), ErrorCode::kEmptyMap);
  TestDrive broken = crossing(1, 1);
  broken.drive.store = std::make_shared<BrokenStore>();
  EXPECT_EQ(error_of(broken), ErrorCode::kTruncatedScan);
}

}  // namespace
}  // namespace sightline

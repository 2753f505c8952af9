#include "passes/remove_moving.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/box_world.h"

namespace sightline {
namespace {

SurfacePoints remove(const TestDrive& test, const RemoveMovingOptions& options = {},
                     int threads = 1) {
  PassContext ctx;
  ctx.threads = threads;
  const Result<SurfacePoints> points = remove_moving(ctx, options, test.drive, test.truth);
  EXPECT_TRUE(points.has_value()) << to_string(points.error());
  return *points;
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
  EXPECT_EQ(remove(crossing(1, 2)).moving_m.size(), 0u);
  const SurfacePoints points = remove(crossing(1, 3));
  ASSERT_EQ(points.moving_m.size(), 1u);
  EXPECT_LT((points.moving_m[0] - Eigen::Vector3d(5.1, 0.1, 1.1)).norm(), 1e-12);
  EXPECT_EQ(points.points_m.size(), 7u);
  EXPECT_EQ(remove(crossing(2, 4)).moving_m.size(), 0u);
  EXPECT_EQ(remove(crossing(2, 5)).moving_m.size(), 2u);
}

TEST(RemoveMoving, LooksNoFartherThanTheCarveRange) {
  RemoveMovingOptions options;
  options.carve_range_m = 5.0;
  EXPECT_EQ(remove(crossing(1, 9), options).moving_m.size(), 0u);
  options.carve_range_m = 6.0;
  EXPECT_EQ(remove(crossing(1, 9), options).moving_m.size(), 1u);
}

TEST(RemoveMoving, KeepsEverythingWhenItIsOff) {
  RemoveMovingOptions options;
  options.enabled = false;
  const SurfacePoints points = remove(crossing(1, 9), options);
  EXPECT_EQ(points.points_m.size(), 20u);
  EXPECT_EQ(points.voxel_m, 0.0);
}

TEST(RemoveMoving, UsesTheScansThatAreAskedForAndCountsWhatIsOutOfRange) {
  TestDrive test = crossing(1, 4);
  test.drive.sensor.max_range_m = 6.0;  // the wall behind is farther
  RemoveMovingOptions options;
  options.scans = "odd";
  const SurfacePoints points = remove(test, options);
  EXPECT_EQ(points.points_m.size(), 2u);
  EXPECT_EQ(points.out_of_range_count, 2u);
}

TEST(RemoveMoving, LeavesAloneWhatEveryScanSeesStanding) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const std::vector<Pose> poses(3, pose_at(0.0, 0.0, 0.1 * static_cast<double>(seed)));
    const SurfacePoints points = remove(drive_through(random_street(seed), poses));
    ASSERT_EQ(points.moving_m.size(), 0u) << "street " << seed;
  }
}

TEST(RemoveMoving, KeepsAStreetThatItDrivesThrough) {
  for (std::uint64_t seed = 0; seed < 2; ++seed) {
    std::vector<Pose> poses;
    for (int i = 0; i < 12; ++i) poses.push_back(pose_at(i, 0.0, 0.0));
    const SurfacePoints points = remove(drive_through(random_street(seed), poses));
    const std::size_t all = points.moving_m.size() + points.points_m.size();
    ASSERT_LT(points.moving_m.size(), all / 500) << "street " << seed;
  }
}

// A car of 4 m comes towards us on the other lane, at 10 m/s.
TEST(RemoveMoving, TakesOutACarThatPassesAndNothingElse) {
  std::vector<Scan> scans;
  std::vector<Pose> poses;
  Pose T_vehicle_lidar = Pose::Identity();
  T_vehicle_lidar.translation().z() = 2.0;
  for (int i = 0; i < 30; ++i) {
    BoxWorld world = random_street(1);
    world.boxes.push_back({{25.0 - i, 2.0, 0.25}, {29.0 - i, 3.8, 1.6}});
    poses.push_back(pose_at(0.5 * i, 0.0, 0.0));
    scans.push_back(scan_world(world, poses.back() * T_vehicle_lidar));
  }
  const SurfacePoints points = remove(drive_of(std::move(scans), poses));
  const auto is_on_lane = [](const Eigen::Vector3d& p) {
    return p.z() > 0.2 && p.y() > 1.9 && p.y() < 3.9;
  };
  const auto left = std::ranges::count_if(points.points_m, is_on_lane);
  const auto taken = std::ranges::count_if(points.moving_m, is_on_lane);
  EXPECT_GT(taken, 250);
  EXPECT_LT(left, taken / 20);
  EXPECT_LT(points.moving_m.size() - static_cast<std::size_t>(taken), points.points_m.size() / 500);
}

TEST(RemoveMoving, GivesTheSameBytesForAnyNumberOfThreads) {
  const TestDrive test = drive_through(
      random_street(9), {pose_at(0.0, 0.0, 0.0), pose_at(1.0, 0.0, 0.0), pose_at(2.0, 0.0, 0.1)});
  const std::vector<std::byte> one = to_bytes(remove(test, {}, 1));
  EXPECT_EQ(to_bytes(remove(test, {}, 2)), one);
  EXPECT_EQ(to_bytes(remove(test, {}, 5)), one);
}

ErrorCode error_of(const TestDrive& test, const RemoveMovingOptions& options = {}) {
  PassContext ctx;
  const Result<SurfacePoints> points = remove_moving(ctx, options, test.drive, test.truth);
  return points ? ErrorCode{} : points.error().code;
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
  RemoveMovingOptions odd;
  odd.scans = "odd";
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

#include <gtest/gtest.h>
#include <algorithm>

#include "passes/trajectory/pieces/seek_piece.h"
#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

PlaceKey key_at(const BoxWorld& world, double x_m, double y_m, double yaw_rad) {
  const Scan scan = scan_world(world, lidar_at(x_m, y_m, yaw_rad), 0.5);
  return place_key(upright_points(scan.points_m, Eigen::Matrix3d::Identity()));
}

TEST(PlaceKey, CountsTheDirectionsOfEachRing) {
  const PlaceKey key = place_key({{1.0, 0.0, 0.0},
                                  {0.0, 1.0, 5.0},
                                  {1.0, 0.001, 1.0},
                                  {-3.0, -0.001, 0.0},
                                  {0.0, 39.9, 0.0},
                                  {0.0, 40.1, 0.0}});
  PlaceKey expected{};
  expected[0] = 2.0F;
  expected[1] = 1.0F;
  expected[19] = 1.0F;
  EXPECT_EQ(key, expected);
  EXPECT_EQ(difference(key, PlaceKey{}), 4.0);
}

// A place seen again, turned and from beside, is nearly always more like itself than like another
// of its street, which looks the same every 6 m.
TEST(PlaceKey, IsNearestAtTheSamePlaceWhateverTheHeading) {
  int asked = 0;
  int won = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const BoxWorld world = random_street(seed);
    for (const double x_m : {0.0, 20.0, 40.0}) {
      const PlaceKey again = key_at(world, x_m + 0.3, 0.4, 2.0);
      const double here = difference(key_at(world, x_m, 0.0, 0.0), again);
      for (double away_m = 10.0; away_m <= 30.0; away_m += 5.0) {
        won += here < difference(key_at(world, x_m - away_m, 0.0, 0.0), again) ? 1 : 0;
        ++asked;
      }
    }
  }
  EXPECT_GE(won, 9 * asked / 10) << "of " << asked;
}

// One piece of 100 m in steps of 1 m, and a second one that passes a passage in its middle.
TEST(PlaceRecognition, FindsTheSamePlaceFirst) {
  BoxWorld world = random_street(2);
  world.boxes.push_back({{14.0, 4.0, 0.0}, {26.0, 4.5, 6.0}});
  world.boxes.push_back({{14.0, -4.5, 0.0}, {26.0, -4.0, 6.0}});
  std::vector<Pose> poses;
  for (int i = -30; i <= 70; ++i) poses.push_back(pose_at(i, 0.0, 0.0));
  const std::size_t first = poses.size();
  for (int i = 0; i < 5; ++i) poses.push_back(pose_at(20.0 - i, 0.5, 3.0));
  const TestDrive test = drive_through(world, poses, 0.5);
  Odometry odometry;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    odometry.T_map_lidar.push_back(poses[i] * test.drive.sensor.T_vehicle_lidar);
    odometry.driven_m.push_back(static_cast<double>(i));
    odometry.piece.push_back(i < first ? 0 : 1);
  }
  const std::vector<ScanRange> pieces = ranges_of(odometry.piece);
  for (const int threads : {1, 3}) {
    TestContext ctx(threads);
    PlaceRecognition places(ctx, test.drive, odometry, pieces);
    const std::vector<Query> queries = value_of(read_queries(test.drive, odometry, pieces[1]));
    const std::vector<std::uint32_t> middles = value_of(places.before(1, queries));
    // The scan at 20 m is the fiftieth; middles lie 25 m apart.
    EXPECT_NEAR(static_cast<double>(middles.front()), 50.0, 12.5);
    std::vector<std::uint32_t> sorted = middles;
    std::ranges::sort(sorted, std::greater());
    EXPECT_EQ(sorted, middles_of(odometry, pieces[0])) << "every place, once";
  }
}

}  // namespace
}  // namespace sightline

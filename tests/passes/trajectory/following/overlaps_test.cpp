#include "passes/trajectory/following/overlaps.h"

#include <gtest/gtest.h>

#include "passes/trajectory/following/odometry.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

using GivenPoses = std::vector<std::optional<Pose>>;

std::vector<Pose> along_a_street(std::size_t count) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < count; ++i)
    poses.push_back(pose_at(0.7 * static_cast<double>(i), 0.0, 0.0));
  return poses;
}

// With given poses of all scans overlaps are computed later, and equal those without given poses.
TEST(Overlaps, OfADriveThatWasLedAreThoseOfOneThatWasNot) {
  const std::vector<Pose> poses = along_a_street(90);
  const TestDrive test = drive_through(random_street(4), poses, 0.5);
  GivenPoses given;
  for (const Pose& pose : poses) given.emplace_back(pose * test.drive.sensor.T_vehicle_lidar);
  PassContext ctx;
  ctx.threads = 2;
  const Result<Odometry> alone = run_odometry(ctx, 50.0, test.drive, GivenPoses(poses.size()));
  const Result<Odometry> led = run_odometry(ctx, 50.0, test.drive, given);
  ASSERT_TRUE(alone.has_value() && led.has_value());
  for (const std::optional<double>& overlap : led->overlap) EXPECT_FALSE(overlap.has_value());
  const auto overlaps = overlaps_along(ctx, test.drive, 50.0, *led);
  ASSERT_TRUE(overlaps.has_value());
  ASSERT_EQ(overlaps->size(), poses.size());
  EXPECT_FALSE(overlaps->front().has_value());
  double sum = 0.0;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    ASSERT_TRUE((*overlaps)[k] && alone->overlap[k]) << k;
    EXPECT_NEAR(*(*overlaps)[k], *alone->overlap[k], 0.1) << k;
    sum += *(*overlaps)[k];
  }
  EXPECT_GT(sum / static_cast<double>(poses.size() - 1), 0.7);
}

TEST(Overlaps, BeginAnewWithEachPiece) {
  const std::vector<Pose> poses = along_a_street(20);
  const TestDrive test = drive_through(random_street(4), poses, 0.5);
  Odometry odometry;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    odometry.T_map_lidar.push_back(poses[k] * test.drive.sensor.T_vehicle_lidar);
    odometry.driven_m.push_back(0.7 * static_cast<double>(k));
    odometry.piece.push_back(k < 10 ? 0 : 1);
  }
  PassContext ctx;
  const auto overlaps = overlaps_along(ctx, test.drive, 50.0, odometry);
  ASSERT_TRUE(overlaps.has_value());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    EXPECT_EQ((*overlaps)[k].has_value(), k % 10 != 0) << k;
  }
}

}  // namespace
}  // namespace sightline

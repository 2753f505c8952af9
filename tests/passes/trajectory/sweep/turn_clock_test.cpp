#include "passes/trajectory/sweep/turn_clock.h"

#include <gtest/gtest.h>

#include "tests/passes/trajectory/sweep/uneven_turns.h"

namespace sightline {
namespace {

Trajectory poses_of(const VehicleMotion& motion, int count, double sigma_rad = 0.0) {
  Random random(3);
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    Pose pose = motion(0.1 * i);
    const Eigen::Vector3d off(random.normal(), random.normal(), random.normal());
    pose.rotate(Eigen::AngleAxisd(sigma_rad * off.norm(), off.normalized()));
    trajectory.poses.push_back(
        {static_cast<std::uint32_t>(i), i * std::int64_t{100'000'000}, pose});
  }
  return trajectory;
}

// Turns that do not repeat within a second.
Pose wandering(double time_s) {
  return pose_at(8.0 * time_s, 0.0, 0.2 * std::sin(1.3 * time_s) + 0.1 * std::sin(3.1 * time_s));
}

TEST(TurnClock, FindsHowFarAClockIsAheadOrBehind) {
  const Trajectory trajectory = poses_of(wandering, 60, 0.0005);
  for (const std::int64_t ahead_ns : {0, 60'000'000, -135'000'000, 400'000'000}) {
    ImuErrors errors;
    errors.ahead_ns = ahead_ns;
    errors.bias_radps = {0.1, -0.2, 0.3};
    errors.sigma_radps = 0.01;
    const std::vector<TurnRate> rates = imu_of(wandering, 6.0, errors);
    const TurnClock clock = turn_clock(trajectory, rates);
    ASSERT_TRUE(clock.is_known);
    EXPECT_NEAR(static_cast<double>(clock.ahead_ns), static_cast<double>(ahead_ns), 10e6);
    EXPECT_GT(clock.explained_moved, 0.95);
    EXPECT_LE(clock.explained_as_is, clock.explained_moved);
    EXPECT_LE(clock.explained_moved, 1.0);
    EXPECT_EQ(moved_by(rates, clock.ahead_ns).front().stamp_ns,
              rates.front().stamp_ns - clock.ahead_ns);
  }
}

TEST(TurnClock, ExplainsNothingByRatesOfAnotherVehicle) {
  const VehicleMotion other = [](double time_s) {
    return pose_at(0.0, 0.0, 0.1 * std::sin(2.3 * time_s));
  };
  const TurnClock clock = turn_clock(poses_of(wandering, 60), imu_of(other, 6.0));
  ASSERT_TRUE(clock.is_known);
  EXPECT_LT(clock.explained_moved, 0.5);
}

TEST(TurnClock, KnowsNothingOfAStraightDriveOrAFewPosesOrAGap) {
  const VehicleMotion straight = [](double time_s) { return pose_at(8.0 * time_s, 0.0, 0.3); };
  const std::vector<TurnRate> rates = imu_of(wandering, 6.0);
  EXPECT_FALSE(turn_clock(poses_of(straight, 60, 0.0001), imu_of(straight, 6.0)).is_known);
  EXPECT_TRUE(turn_clock(poses_of(wandering, 40), rates).is_known);
  EXPECT_FALSE(turn_clock(poses_of(wandering, 20), rates).is_known);
  EXPECT_FALSE(turn_clock(poses_of(wandering, 60), {}).is_known);
  std::vector<TurnRate> seldom;
  for (std::size_t i = 0; i < rates.size(); i += 11) seldom.push_back(rates[i]);
  EXPECT_FALSE(turn_clock(poses_of(wandering, 60), seldom).is_known);
}

}  // namespace
}  // namespace sightline

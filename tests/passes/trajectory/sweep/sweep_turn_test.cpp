#include "passes/trajectory/sweep/sweep_turn.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/swept_world.h"

namespace sightline {
namespace {

constexpr double kPi = std::numbers::pi;

// Rings of points to the left, each from `begin_rad` once round.
std::vector<Eigen::Vector3d> rings(int count, double begin_rad) {
  std::vector<Eigen::Vector3d> points_m;
  for (int ring = 0; ring < count; ++ring) {
    for (int i = 0; i < 600; ++i) {
      const double at_rad = begin_rad + 2.0 * kPi * i / 600.0;
      points_m.emplace_back(10.0 * std::cos(at_rad), 10.0 * std::sin(at_rad), 0.1 * ring);
    }
  }
  return points_m;
}

TEST(SweepTurn, MayBeAnyOfThreeWhereRingsFollowEachOther) {
  const std::vector<SweepTurn> turns = turns_of_rings(rings(16, 0.5));
  ASSERT_EQ(turns.size(), 3u);
  EXPECT_EQ(turns[0].begin_rad, kPi);
  EXPECT_TRUE(turns[0].is_clockwise);
  EXPECT_EQ(turns[1].begin_rad, kPi);
  EXPECT_FALSE(turns[1].is_clockwise);
  EXPECT_NEAR(turns[2].begin_rad, 0.5, 1e-12);
  EXPECT_FALSE(turns[2].is_clockwise);
  std::vector<Eigen::Vector3d> backwards_m = rings(16, 0.5);
  std::ranges::reverse(backwards_m);
  EXPECT_TRUE(turns_of_rings(backwards_m)[2].is_clockwise);
}

TEST(SweepTurn, IsOneOfTwoWhereRingsBeginBehind) {
  EXPECT_EQ(turns_of_rings(rings(16, kPi - 0.01)).size(), 2u);
  EXPECT_EQ(turns_of_rings(rings(16, -kPi + 0.01)).size(), 2u);
}

TEST(SweepTurn, IsNotKnownByAnotherOrder) {
  EXPECT_TRUE(turns_of_rings({}).empty());
  EXPECT_TRUE(turns_of_rings(rings(4, 0.0)).empty());
  std::vector<Eigen::Vector3d> mixed_m = rings(16, 0.0);
  Random random(3);
  for (std::size_t i = mixed_m.size(); i > 1; --i) {
    std::swap(mixed_m[i - 1], mixed_m[random.next() % i]);
  }
  EXPECT_TRUE(turns_of_rings(mixed_m).empty());
  const VehicleMotion still = [](double) { return Pose::Identity(); };
  const BoxWorld world = random_street(1);
  EXPECT_TRUE(turns_of_rings(sweep_world(world, still, 0.0, PointOrder::kTime).points_m).empty());
  EXPECT_FALSE(turns_of_rings(sweep_world(world, still, 0.0, PointOrder::kRings).points_m).empty());
}

TEST(SweepTurn, GivesTimesByAzimuth) {
  const std::vector<Eigen::Vector3d> ahead_left_behind_right = {
      {5.0, 0.0, 1.0}, {0.0, 5.0, 0.0}, {-5.0, 1e-9, 0.0}, {0.0, -5.0, -1.0}};
  const std::vector<double> clockwise = turn_times(ahead_left_behind_right, {kPi, true});
  const double expected[] = {0.5, 0.25, 0.0, 0.75};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(clockwise[i], expected[i], 1e-9) << i;
  const std::vector<double> left = turn_times(ahead_left_behind_right, {0.0, false});
  const double expected_left[] = {0.0, 0.25, 0.5, 0.75};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(left[i], expected_left[i], 1e-9) << i;
}

// Any begin and direction: times are shares, and rise with the turn.
TEST(SweepTurn, GivesTimesThatRiseFromItsBeginning) {
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const SweepTurn turn{random.uniform(-kPi, kPi), i % 2 == 0};
    double before = 0.0;
    for (const double share : {0.001, 0.2, 0.5, 0.7, 0.999}) {
      const double at_rad = turn.begin_rad + (turn.is_clockwise ? -1.0 : 1.0) * share * 2.0 * kPi;
      const Eigen::Vector3d point_m(3.0 * std::cos(at_rad), 3.0 * std::sin(at_rad), 1.0);
      const double time = turn_times(std::vector{point_m}, turn).front();
      EXPECT_NEAR(time, share, 1e-9);
      EXPECT_GT(time, before);
      before = time;
    }
  }
}

}  // namespace
}  // namespace sightline

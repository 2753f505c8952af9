#include "passes/trajectory/sweep/sweep_times.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sightline {
namespace {

// One turn, clockwise, in the order of time.
std::vector<Eigen::Vector3d> sweep(std::size_t count, double turn_rad) {
  std::vector<Eigen::Vector3d> points_m;
  for (std::size_t i = 0; i < count; ++i) {
    const double at_rad = -turn_rad * static_cast<double>(i) / static_cast<double>(count);
    points_m.emplace_back(10.0 * std::cos(at_rad), 10.0 * std::sin(at_rad), 0.0);
  }
  return points_m;
}

TEST(SweepTimes, FollowATurnByTheOrderOfItsPoints) {
  const std::vector<double> times = sweep_times(sweep(20000, 2.0 * std::numbers::pi));
  ASSERT_EQ(times.size(), 20000u);
  EXPECT_NEAR(times[5000], 0.25, 0.02);
  EXPECT_NEAR(times[15000], 0.75, 0.02);
  EXPECT_TRUE(std::ranges::is_sorted(times));
}

TEST(SweepTimes, AreEmptyForAnotherOrder) {
  std::vector<Eigen::Vector3d> points_m = sweep(20000, 2.0 * std::numbers::pi);
  EXPECT_TRUE(sweep_times(std::span(points_m).first(100)).empty());
  EXPECT_TRUE(sweep_times(sweep(20000, 1.0)).empty());
  EXPECT_TRUE(sweep_times(sweep(20000, 16.0 * std::numbers::pi)).empty());  // ring by ring
}

}  // namespace
}  // namespace sightline

#include "passes/matching/autoware_sampler.h"

#include <gtest/gtest.h>

#include <cmath>

#include "passes/matching/scan_preparation.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

SensorProfile raised_sensor() {
  SensorProfile sensor;
  sensor.T_vehicle_lidar.translation() = Eigen::Vector3d(0.5, 0.0, 1.8);
  return sensor;
}

// One return in the middle of each of so many voxels of 3 m, as the vehicle sees them.
Scan one_return_a_voxel(int voxels_a_side) {
  Scan scan;
  const Pose T_lidar_vehicle = raised_sensor().T_vehicle_lidar.inverse();
  for (int x = 0; x < voxels_a_side; ++x) {
    for (int y = 0; y < voxels_a_side; ++y) {
      scan.points_m.push_back(T_lidar_vehicle * Eigen::Vector3d(3 * x - 58.5, 3 * y - 58.5, 1.5));
    }
  }
  return scan;
}

TEST(AutowareSampler, IsBoxRangeAndVoxelsOfTheVehicle) {
  Random random(5);
  AutowareSampler sampler;  // one for all: nothing of a scan may be left in the next
  const SensorProfile sensor = raised_sensor();
  for (int trial = 0; trial < 20; ++trial) {
    Scan scan;
    const double range_m = random.uniform(20.0, 120.0);
    std::vector<Eigen::Vector3d> expected_m;
    for (std::uint64_t i = random.below(3000); i > 0; --i) {
      const Eigen::Vector3d p_m = random_vector(random, -80.0, 80.0);
      scan.points_m.push_back(p_m);
      const Eigen::Vector3d q_m = sensor.T_vehicle_lidar * p_m;
      const bool is_in_box =
          std::max(std::abs(q_m.x()), std::abs(q_m.y())) <= 60.0 && q_m.z() >= -30 && q_m.z() <= 50;
      if (is_in_box && p_m.norm() <= range_m) expected_m.push_back(q_m);
    }
    expected_m = voxel_subsample(expected_m, 3.0);
    if (expected_m.size() > 1500) continue;
    EXPECT_EQ(sampler.sample(scan, sensor, range_m, 1), expected_m);
  }
}

TEST(AutowareSampler, TakesOf1600VoxelsAnyAsLikelyAsAnotherAndBySeedAlone) {
  const Scan scan = one_return_a_voxel(40);
  const SensorProfile sensor = raised_sensor();
  AutowareSampler sampler;
  std::map<std::pair<double, double>, int> times;
  constexpr int kSeeds = 64;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const std::vector<Eigen::Vector3d> points_m = sampler.sample(scan, sensor, 200.0, seed);
    ASSERT_EQ(points_m.size(), 1500U);
    for (const Eigen::Vector3d& p_m : points_m) ++times[{p_m.x(), p_m.y()}];
    EXPECT_EQ(points_m, sampler.sample(scan, sensor, 200.0, seed));
  }
  ASSERT_EQ(times.size(), 1600U);
  // 60 of 64 on average, with a standard deviation of 2.
  for (const auto& [place_m, count] : times) EXPECT_GE(count, kSeeds * 3 / 4);
}

TEST(AutowareSampler, OfNothingIsNothing) {
  AutowareSampler sampler;
  EXPECT_TRUE(sampler.sample({}, raised_sensor(), 50.0, 1).empty());
}

}  // namespace
}  // namespace sightline

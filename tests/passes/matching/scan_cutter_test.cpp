#include "passes/matching/scan_cutter.h"

#include <gtest/gtest.h>
#include <cmath>

#include "passes/matching/scan_preparation.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

std::vector<Eigen::Vector3d> random_returns(Random& random, std::size_t count, double reach_m) {
  std::vector<Eigen::Vector3d> points_m;
  for (std::size_t i = 0; i < count; ++i) {
    points_m.push_back(random_vector(random, -reach_m, reach_m));
  }
  return points_m;
}

// Number floor(n stride), n = 0, 1, ..
std::vector<Eigen::Vector3d> every(double stride, const std::vector<Eigen::Vector3d>& points_m) {
  std::vector<Eigen::Vector3d> some_m;
  for (double n = 0.0; std::floor(n * stride) < static_cast<double>(points_m.size()); n += 1.0) {
    some_m.push_back(points_m[static_cast<std::size_t>(std::floor(n * stride))]);
  }
  return some_m;
}

TEST(ScanCutter, TakesEverySecondReturnWithinTheRangeAndAveragesItsVoxel) {
  const std::vector<Eigen::Vector3d> points_m = {
      {0.25, 0.5, 0.5}, {0.3, 0.5, 0.5},  {0.75, 0.5, 0.5}, {1.5, 0.5, 0.5},
      {3.5, 0.5, 0.5},  {-0.5, 0.0, 0.0}, {0.0, 0.0, -3.0}};
  const std::vector<Eigen::Vector3d> expected_m = {{0.0, 0.0, -3.0}, {0.5, 0.5, 0.5}};
  ScanCutter cutter;
  EXPECT_EQ(cutter.cut(points_m, {3.0, 1.0}, 2.0), expected_m);
}

TEST(ScanCutter, IsCropAndSubsampleOfTheReturnsItTakes) {
  Random random(41);
  ScanCutter cutter;  // one for all: nothing of a scan may be left in the next
  for (int trial = 0; trial < 60; ++trial) {
    const std::size_t count = random.below(4000);
    const std::vector<Eigen::Vector3d> points_m = random_returns(random, count, 30.0);
    // The last range with the smallest voxels has more cells than a table holds.
    const ScanCut cut{random.uniform(1.0, 60.0), trial % 3 == 0 ? 0.4 : 1.0};
    for (const double stride : {1.0, 1.6180339887498949, 2.0, 5.6180339887498949}) {
      EXPECT_EQ(cutter.cut(points_m, cut, stride),
                voxel_subsample(crop(every(stride, points_m), cut.range_m), cut.leaf_m))
          << count << " points, range " << cut.range_m << ", stride " << stride;
    }
  }
}

TEST(ScanCutter, OfNothingIsNothing) {
  ScanCutter cutter;
  EXPECT_TRUE(cutter.cut({}, {10.0, 1.0}, 2.618).empty());
}

TEST(ReturnStride, LeavesReturnsAQuarterOfAVoxelApartAtMost) {
  for (const double step_deg : {0.1, 0.2, 0.4}) {
    for (double range_m = 2.0; range_m < 120.0; range_m += 0.5) {
      for (const double leaf_m : {0.5, 1.0, 2.0}) {
        const double stride = return_stride({range_m, leaf_m}, step_deg);
        const double spacing_m = range_m * step_deg * std::acos(-1.0) / 180.0;
        ASSERT_GE(stride, 1.0);
        if (stride == 1.0) continue;
        EXPECT_LE(stride * spacing_m, 0.25 * leaf_m * (1.0 + 1e-12));
        EXPECT_NEAR(stride - std::floor(stride), 0.6180339887498949, 1e-9);
      }
    }
  }
  EXPECT_EQ(return_stride({50.0, 1.0}, 0.2), 1.0);
  EXPECT_NEAR(return_stride({10.0, 1.0}, 0.2), 6.618, 1e-3);
}

TEST(ReturnStride, MeetsAllRingsAlike) {
  for (const std::size_t ring_count : {16u, 32u, 40u, 64u, 128u}) {
    for (double range_m = 5.0; range_m <= 50.0; range_m += 5.0) {
      const double stride = return_stride({range_m, 1.0}, 0.2);
      std::vector<double> of_ring(ring_count, 0.0);
      const double turns = 1800.0;
      for (double n = 0.0; n * stride < turns * static_cast<double>(ring_count); n += 1.0) {
        of_ring[static_cast<std::size_t>(n * stride) % ring_count] += 1.0;
      }
      for (const double count : of_ring) {
        // A stride of a whole number would meet some of 16 rings twice as often, others never.
        EXPECT_NEAR(count * stride / turns, 1.0, 0.1) << ring_count << " rings at " << range_m;
      }
    }
  }
}

SensorProfile raised_sensor() {
  SensorProfile sensor;
  sensor.T_vehicle_lidar.translation() = Eigen::Vector3d(0.5, 0.0, 1.8);
  return sensor;
}

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
    const AutowareFilters filters = {random.uniform(15.0, 60.0), random.uniform(1.0, 3.0), 1500,
                                     random.uniform(20.0, 120.0)};
    std::vector<Eigen::Vector3d> expected_m;
    for (std::uint64_t i = random.below(3000); i > 0; --i) {
      const Eigen::Vector3d p_m = random_vector(random, -80.0, 80.0);
      scan.points_m.push_back(p_m);
      const Eigen::Vector3d q_m = sensor.T_vehicle_lidar * p_m;
      const bool is_in_box = std::max(std::abs(q_m.x()), std::abs(q_m.y())) <= filters.box_m &&
                             q_m.z() >= -30 && q_m.z() <= 50;
      if (is_in_box && p_m.norm() <= filters.range_m) expected_m.push_back(q_m);
    }
    expected_m = voxel_subsample(expected_m, filters.voxel_m);
    if (expected_m.size() > 1500) continue;
    EXPECT_EQ(sampler.sample(scan, sensor, filters, 1), expected_m);
  }
}

TEST(AutowareSampler, TakesOf1600VoxelsAnyAsLikelyAsAnotherAndBySeedAlone) {
  const Scan scan = one_return_a_voxel(40);
  const SensorProfile sensor = raised_sensor();
  AutowareSampler sampler;
  std::map<std::pair<double, double>, int> times;
  constexpr int kSeeds = 64;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const std::vector<Eigen::Vector3d> points_m =
        sampler.sample(scan, sensor, AutowareFilters(), seed);
    ASSERT_EQ(points_m.size(), 1500U);
    for (const Eigen::Vector3d& p_m : points_m) ++times[{p_m.x(), p_m.y()}];
    EXPECT_EQ(points_m, sampler.sample(scan, sensor, AutowareFilters(), seed));
  }
  ASSERT_EQ(times.size(), 1600U);
  // 60 of 64 on average, with a standard deviation of 2.
  for (const auto& [place_m, count] : times) EXPECT_GE(count, kSeeds * 3 / 4);
}

TEST(AutowareSampler, OfNothingIsNothing) {
  AutowareSampler sampler;
  EXPECT_TRUE(sampler.sample({}, raised_sensor(), AutowareFilters(), 1).empty());
}

}  // namespace
}  // namespace sightline

#include "passes/factors/paper/normal_entropy.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "formats/base/random.h"

namespace sightline {
namespace {

Eigen::Vector3d random_direction(Random& random) {
  const Eigen::Vector3d direction(random.normal(), random.normal(), random.normal());
  return direction.normalized();
}

TEST(NormalEntropy, PutsVerticalsIntoTheCapAndHorizontalsOnTheRim) {
  EXPECT_EQ(normal_bin({0.0, 0.0, 1.0}), 0);
  EXPECT_EQ(normal_bin({0.0, 0.0, -1.0}), 0);
  EXPECT_EQ(normal_bin({1.0, 0.0, 0.0}), 1);
  EXPECT_EQ(normal_bin({0.0, 1.0, 0.0}), 1 + 9);  // 90 degrees of sectors of 10
}

TEST(NormalEntropy, GivesANormalAndItsOppositeTheSameBin) {
  Random random(1);
  for (int i = 0; i < 5000; ++i) {
    Eigen::Vector3d direction = random_direction(random);
    if (i % 4 == 0) direction = Eigen::Vector3d(direction.x(), direction.y(), 0.0).normalized();
    ASSERT_EQ(normal_bin(direction), normal_bin(-direction)) << direction.transpose();
  }
}

TEST(NormalEntropy, UsesBinsOfEqualArea) {
  constexpr int kSamples = 146000;  // 2000 a bin
  Random random(2);
  std::array<int, kNormalBinCount> histogram{};
  for (int i = 0; i < kSamples; ++i) {
    ++histogram.at(static_cast<std::size_t>(normal_bin(random_direction(random))));
  }
  // Five standard deviations of a count of 2000.
  for (const int count : histogram) EXPECT_NEAR(count, 2000, 5.0 * std::sqrt(2000.0));
}

TEST(NormalEntropy, IsTheEntropyOfPlanarNdsAlone) {
  Vicinity vicinity;
  vicinity.ranges_m = {10.0, 20.0, 30.0};
  vicinity.nd_index = {0, 1, 2, 3, 4};
  vicinity.end = {1, 3, 5};
  const std::vector<int> bins = {-1, 4, 9, 9, 4};
  const std::vector<double> entropy = normal_entropy(vicinity, bins);
  EXPECT_EQ(entropy[0], 0.0);  // no planar ND
  EXPECT_DOUBLE_EQ(entropy[1], 1.0);
  EXPECT_DOUBLE_EQ(entropy[2], 1.0);
}

}  // namespace
}  // namespace sightline

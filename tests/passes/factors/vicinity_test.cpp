#include "passes/factors/vicinity.h"

#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <limits>

#include "formats/base/random.h"

namespace sightline {
namespace {

Nd nd_at(double x_m) {
  Nd nd;
  nd.mean_m = {x_m, 0.0, 0.0};
  nd.key = cell_key(nd.mean_m, 2.0);
  return nd;
}

TEST(Vicinity, HoldsNdsNearestFirstAndThoseAtExactlyTheRange) {
  const std::vector<Nd> nds = {nd_at(30.0), nd_at(10.0), nd_at(5.0), nd_at(10.5), nd_at(30.5)};
  const std::vector<std::uint32_t> all = {0, 1, 2, 3, 4};
  const Vicinity vicinity = vicinity_of(Eigen::Vector3d::Zero(), nds, all, {10.0, 20.0, 30.0});
  EXPECT_EQ(vicinity.nd_index, (std::vector<std::uint32_t>{2, 1, 3, 0}));
  EXPECT_EQ(vicinity.end, (std::vector<std::size_t>{2, 3, 4}));
  EXPECT_EQ(feature_count(vicinity), (std::vector<double>{2.0, 3.0, 4.0}));
}

TEST(Vicinity, BreaksTiesOfDistanceByCellKey) {
  const std::vector<Nd> nds = {nd_at(5.0), nd_at(-5.0)};
  const std::vector<std::uint32_t> forward = {0, 1};
  const std::vector<std::uint32_t> backward = {1, 0};
  const Eigen::Vector3d p_m = Eigen::Vector3d::Zero();
  EXPECT_EQ(vicinity_of(p_m, nds, forward, {10.0}).nd_index, (std::vector<std::uint32_t>{1, 0}));
  EXPECT_EQ(vicinity_of(p_m, nds, backward, {10.0}).nd_index, (std::vector<std::uint32_t>{1, 0}));
}

TEST(Vicinity, LooksOnlyAtCandidates) {
  const std::vector<Nd> nds = {nd_at(1.0), nd_at(3.0), nd_at(5.0)};
  const std::vector<std::uint32_t> some = {2};
  EXPECT_EQ(vicinity_of(Eigen::Vector3d::Zero(), nds, some, {10.0}).nd_index, some);
}

TEST(Dimensions, CountsEachClassWithinEachRange) {
  Vicinity vicinity;
  vicinity.ranges_m = {10.0, 20.0};
  vicinity.nd_index = {0, 1, 2, 3, 4};
  vicinity.end = {2, 5};
  const std::vector<int> dimension_class = {2, 1, 2, 3, 2};
  EXPECT_EQ(dimension_counts(vicinity, dimension_class),
            (std::vector<ByDimension>{{1.0, 1.0, 0.0}, {1.0, 3.0, 1.0}}));
}

TEST(Dimensions, RatiosAreSharesAndAllZeroOfNothing) {
  EXPECT_EQ(dimension_ratios({1.0, 3.0, 4.0}), (ByDimension{0.125, 0.375, 0.5}));
  EXPECT_EQ(dimension_ratios({0.0, 0.0, 0.0}), (ByDimension{0.0, 0.0, 0.0}));
}

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

TEST(OccupancyRatio, CountsCellsHitWithinEachRangeAndAtExactlyIt) {
  const float nothing = std::numeric_limits<float>::infinity();
  const std::vector<float> distance_m = {5.0F, 10.0F, 10.5F, nothing, 20.0F, 20.5F, 3.0F, nothing};
  EXPECT_EQ(occupancy_ratio(distance_m, {10.0, 20.0, 50.0}),
            (std::vector<double>{3.0 / 8.0, 5.0 / 8.0, 6.0 / 8.0}));
}

TEST(OccupancyRatio, IsOfTheCellsInView) {
  const float out = std::numeric_limits<float>::quiet_NaN();
  const float nothing = std::numeric_limits<float>::infinity();
  EXPECT_EQ(occupancy_ratio(std::vector<float>{out, 5.0F, out, nothing, 15.0F, out, nothing},
                            {10.0, 20.0}),
            (std::vector<double>{1.0 / 4.0, 2.0 / 4.0}));
  EXPECT_EQ(occupancy_ratio(std::vector<float>{out, out}, {10.0}), (std::vector<double>{0.0}));
}

TEST(RAverage, IsTheMeanDistanceAndTheRangeItselfWhereThereIsNothing) {
  Vicinity vicinity;
  vicinity.ranges_m = {5.0, 10.0, 20.0};
  vicinity.nd_index = {0, 1, 2};
  vicinity.distance_m = {6.0, 8.0, 16.0};
  vicinity.end = {0, 2, 3};
  EXPECT_EQ(r_average(vicinity), (std::vector<double>{5.0, 7.0, 10.0}));
}

}  // namespace
}  // namespace sightline

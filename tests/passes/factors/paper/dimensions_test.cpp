#include "passes/factors/paper/dimensions.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

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

}  // namespace
}  // namespace sightline

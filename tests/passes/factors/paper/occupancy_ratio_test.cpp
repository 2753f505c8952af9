#include "passes/factors/paper/occupancy_ratio.h"

#include <gtest/gtest.h>

#include <limits>

namespace sightline {
namespace {

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

}  // namespace
}  // namespace sightline

#include "formats/base/statistics.h"

#include <gtest/gtest.h>

#include <vector>

namespace sightline {
namespace {

TEST(Statistics, MeanAndQuantilesOfAFewNumbers) {
  const std::vector<double> values = {1.0, 2.0, 4.0, 9.0};
  EXPECT_EQ(mean_of(values), 4.0);
  EXPECT_EQ(quantile_of_sorted(values, 0.0), 1.0);
  EXPECT_EQ(quantile_of_sorted(values, 0.5), 3.0);
  EXPECT_NEAR(quantile_of_sorted(values, 0.9), 4.0 + 0.7 * 5.0, 1e-12);
  EXPECT_EQ(quantile_of_sorted(values, 1.0), 9.0);
  EXPECT_EQ(quantile_of_sorted(std::vector<double>{7.0}, 0.9), 7.0);
}

}  // namespace
}  // namespace sightline

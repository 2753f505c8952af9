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

TEST(Evenly, TakesTheMiddleOfEqualStretches) {
  EXPECT_EQ(evenly(8, 2), (std::vector<std::size_t>{2, 6}));
  EXPECT_EQ(evenly(10, 3), (std::vector<std::size_t>{1, 5, 8}));
  EXPECT_EQ(evenly(100, 1), (std::vector<std::size_t>{50}));
}

TEST(Evenly, TakesAllOfFewAndEachOnce) {
  EXPECT_EQ(evenly(3, 8), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_TRUE(evenly(0, 8).empty());
  for (std::size_t size = 1; size < 40; ++size) {
    const std::vector<std::size_t> chosen = evenly(size, 7);
    EXPECT_LT(chosen.back(), size);
    for (std::size_t i = 1; i < chosen.size(); ++i) EXPECT_LT(chosen[i - 1], chosen[i]) << size;
  }
}

}  // namespace
}  // namespace sightline

#include "formats/base/random.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Random, GivesTheSameNumbersEverywhere) {
  Random random(0);
  EXPECT_EQ(random.next(), 0xe220a8397b1dcdafULL);  // SplitMix64's first output for seed 0
}

TEST(Random, HasTheMomentsOfItsDistributions) {
  Random random(mix(3, 4));
  constexpr int kCount = 100'000;
  double sum = 0.0;
  double normal_sum = 0.0;
  double normal_squares = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    const double n = random.normal();
    normal_sum += n;
    normal_squares += n * n;
  }
  EXPECT_NEAR(sum / kCount, 0.5, 0.005);
  EXPECT_NEAR(normal_sum / kCount, 0.0, 0.015);
  EXPECT_NEAR(normal_squares / kCount, 1.0, 0.02);
}

TEST(Random, StaysBelowItsBound) {
  Random random(9);
  for (int i = 0; i < 1000; ++i) EXPECT_LT(random.below(7), 7U);
}

TEST(Mix, SeparatesNeighbouringUnits) {
  EXPECT_NE(mix(1, 2), mix(2, 1));
  EXPECT_NE(mix(1, 2), mix(1, 3));
}

}  // namespace
}  // namespace sightline

#include "passes/factors/paper/score_entropy.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline {
namespace {

const double kLog289 = std::log2(289.0);

TEST(ScoreEntropy, IsLargestWhereNothingTellsShiftsApart) {
  ShiftGrid score;
  score.fill(3.0);
  EXPECT_NEAR(score_entropy(score), kLog289, 1e-12);
  score.fill(0.0);
  EXPECT_EQ(score_entropy(score), kLog289);
}

TEST(ScoreEntropy, OfOnePeakIsTheEntropyOfOneWeightAmongMany) {
  ShiftGrid score{};
  score[144] = 5.0;
  // Softmax of 10 for the peak and 0 for the 288 others.
  const double total = std::exp(10.0) + 288.0;
  const double peak = std::exp(10.0) / total;
  const double other = 1.0 / total;
  EXPECT_NEAR(score_entropy(score), -peak * std::log2(peak) - 288.0 * other * std::log2(other),
              1e-12);
}

TEST(ScoreEntropy, DoesNotDependOnTheScale) {
  ShiftGrid score;
  ShiftGrid scaled;
  for (std::size_t v = 0; v < kShiftCount; ++v) {
    score[v] = std::cos(0.1 * static_cast<double>(v)) + 1.5;
    scaled[v] = 1000.0 * score[v];
  }
  EXPECT_NEAR(score_entropy(score), score_entropy(scaled), 1e-12);
}

}  // namespace
}  // namespace sightline

#include "formats/evaluation/look_evaluation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "formats/base/random.h"

namespace sightline {
namespace {

TEST(EqualCoverage, IsLinearBetweenNeighboursThatNoAnswerBeats) {
  // 0.93 at .5 is beaten by 0.94 at .2, and lies between no neighbours.
  const std::vector<CoveredCost> answers = {{0.98, 0.4}, {0.93, 0.5}, {0.90, 0.1}, {0.94, 0.2}};
  EXPECT_NEAR(cost_at_coverage(answers, 0.92).cost, 0.15, 1e-12);
  EXPECT_NEAR(cost_at_coverage(answers, 0.94).cost, 0.2, 1e-12);
  EXPECT_NEAR(cost_at_coverage(answers, 0.97).cost, 0.35, 1e-12);
  EXPECT_NEAR(cost_at_coverage(answers, 0.50).cost, 0.1, 1e-12);
  EXPECT_DOUBLE_EQ(cost_at_coverage(answers, 0.97).coverage, 0.97);
  EXPECT_TRUE(cost_at_coverage(answers, 0.98).is_reached);
}

TEST(EqualCoverage, TakesTheMostAccurateAnswerWhereNoneCoversAsMuch) {
  const CostAtCoverage found =
      cost_at_coverage(std::vector<CoveredCost>{{0.9, 0.1}, {0.95, 0.3}, {0.95, 0.4}}, 0.96);
  EXPECT_FALSE(found.is_reached);
  EXPECT_EQ(found.coverage, 0.95);
  EXPECT_EQ(found.cost, 0.3);
}

// Answers that no other beats, one by one against all, in order; then between the two around it.
double by_force(const std::vector<CoveredCost>& answers, double coverage) {
  std::vector<CoveredCost> unbeaten;
  for (const CoveredCost& a : answers) {
    const bool is_beaten = std::ranges::any_of(answers, [&](const CoveredCost& b) {
      return b.coverage >= a.coverage && b.cost <= a.cost &&
             (b.coverage > a.coverage || b.cost < a.cost);
    });
    if (!is_beaten) unbeaten.push_back(a);
  }
  std::ranges::sort(unbeaten, {}, &CoveredCost::coverage);
  if (coverage <= unbeaten.front().coverage) return unbeaten.front().cost;
  for (std::size_t i = 1; i < unbeaten.size(); ++i) {
    const CoveredCost& low = unbeaten[i - 1];
    const CoveredCost& high = unbeaten[i];
    if (coverage > high.coverage || high.coverage == low.coverage) continue;
    return low.cost +
           (high.cost - low.cost) * (coverage - low.coverage) / (high.coverage - low.coverage);
  }
  return unbeaten.back().cost;
}

TEST(EqualCoverage, AgreesWithTheFrontierFoundByForceAndNeverFallsWithCoverage) {
  Random random(17);
  for (int round = 0; round < 2000; ++round) {
    std::vector<CoveredCost> answers(1 + random.below(9));
    for (CoveredCost& answer : answers) {
      answer = {0.1 * static_cast<double>(random.below(11)),
                0.25 * static_cast<double>(1 + random.below(8))};
    }
    double before = 0.0;
    for (int step = 0; step <= 40; ++step) {
      const double coverage = 0.025 * step;
      const CostAtCoverage found = cost_at_coverage(answers, coverage);
      ASSERT_NEAR(found.cost, by_force(answers, coverage), 1e-12) << round << " at " << coverage;
      ASSERT_EQ(found.is_reached, std::ranges::any_of(answers, [&](const CoveredCost& answer) {
                  return answer.coverage >= coverage;
                }));
      ASSERT_GE(found.cost, before - 1e-12);
      before = found.cost;
    }
  }
}

}  // namespace
}  // namespace sightline

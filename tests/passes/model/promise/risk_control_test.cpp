#include "passes/model/promise/risk_control.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/passes/model/promise/answered_world.h"

namespace sightline {
namespace {

// One threshold per entry: each of `block_count` blocks of 100 sites answers and misses that many.
struct OfBlock {
  std::uint32_t answered = 100;
  std::uint32_t missed = 0;
};
BlockCounts uniform_counts(std::size_t block_count, const std::vector<OfBlock>& at_thresholds) {
  BlockCounts counts;
  counts.sites_in_block.assign(block_count, 100);
  for (std::size_t t = 0; t < at_thresholds.size(); ++t) {
    counts.thresholds.push_back(0.1 * static_cast<double>(t + 1));
    counts.answered.emplace_back(block_count, at_thresholds[t].answered);
    counts.missed.emplace_back(block_count, at_thresholds[t].missed);
  }
  return counts;
}

TEST(RiskControl, EmpiricallyTakesTheLeastThresholdThatMissesRarelyEnough) {
  const RiskDecision decision =
      decide_empirically(uniform_counts(2, {{100, 30}, {80, 4}, {50, 1}, {10, 0}}), 0.05);
  EXPECT_NEAR(decision.threshold, 0.2, 1e-12);
  EXPECT_NEAR(decision.miss_share, 0.05, 1e-12) << "of the answered sites";
  EXPECT_NEAR(decision.answered_share, 0.8, 1e-12);
  EXPECT_FALSE(decision.is_earned);
}

TEST(RiskControl, TakesTheLeastMissesThereAreWhereNoneAreRareEnough) {
  const RiskDecision decision =
      decide_empirically(uniform_counts(2, {{100, 30}, {100, 12}, {50, 6}, {0, 0}}), 0.05);
  EXPECT_NEAR(decision.threshold, 0.2, 1e-12);
  EXPECT_NEAR(decision.miss_share, 0.12, 1e-12);
}

TEST(RiskControl, AnswersNothingWhereNoThresholdDoes) {
  const BlockCounts counts = uniform_counts(50, {{0, 0}, {0, 0}});
  for (const RiskDecision& decision :
       {decide_empirically(counts, 0.05), decide_conformally(counts, {0.05, 0.1}),
        decide_by_testing(counts, {0.05, 0.1})}) {
    EXPECT_FALSE(decision.is_earned);
    EXPECT_EQ(decision.answered_share, 0.0);
    EXPECT_EQ(decision.miss_share, 0.0);
    EXPECT_EQ(decision.needed_blocks, 0u) << "no number of blocks is enough";
  }
}

TEST(RiskControl, ConformallyLeavesRoomForOneMoreBlock) {
  // n = 39: (39 m + 1) / (39 + 1) <= 0.05 needs m <= 1 / 39 = 2.56 %.
  const RiskDecision decision = decide_conformally(
      uniform_counts(39, {{100, 30}, {100, 5}, {100, 3}, {100, 2}, {100, 1}}), {0.05, 0.1});
  EXPECT_TRUE(decision.is_earned);
  EXPECT_NEAR(decision.threshold, 0.4, 1e-12);
  EXPECT_EQ(decision.needed_blocks, 19u);
}

TEST(RiskControl, ConformallyCountsMissesAmongAnswersAlone) {
  // A quarter is hopeless: 1 % of all missed, of the answered 4 / 300.
  const RiskDecision decision =
      decide_conformally(uniform_counts(40, {{100, 26}, {75, 1}, {20, 0}}), {0.05, 0.1});
  EXPECT_TRUE(decision.is_earned);
  EXPECT_NEAR(decision.threshold, 0.2, 1e-12);
  EXPECT_NEAR(decision.answered_share, 0.75, 1e-12);
  EXPECT_NEAR(decision.miss_share, 1.0 / 75.0, 1e-12);
}

TEST(RiskControl, ConformallyNeedsNineteenAnsweredBlocksForFivePercent) {
  EXPECT_FALSE(decide_conformally(uniform_counts(18, {{}, {}}), {0.05, 0.1}).is_earned);
  EXPECT_TRUE(decide_conformally(uniform_counts(19, {{}, {}}), {0.05, 0.1}).is_earned);
  const RiskDecision half = decide_conformally(uniform_counts(37, {{50, 0}}), {0.05, 0.1});
  EXPECT_FALSE(half.is_earned);
  EXPECT_EQ(half.needed_blocks, 38u) << "of blocks that are answered half";
  EXPECT_TRUE(decide_conformally(uniform_counts(38, {{50, 0}}), {0.05, 0.1}).is_earned);
}

TEST(RiskControl, ConformallyDoesNotTrustABlockThatMissesMoreAtAStricterThreshold) {
  EXPECT_NEAR(
      decide_conformally(uniform_counts(39, {{100, 1}, {100, 9}, {90, 1}}), {0.05, 0.1}).threshold,
      0.3, 1e-12);
}

TEST(RiskControl, FallsBackToWhatWasSeenWhereNothingIsEarned) {
  const RiskDecision decision =
      decide_conformally(uniform_counts(5, {{100, 30}, {100, 5}, {50, 0}}), {0.05, 0.1});
  EXPECT_FALSE(decision.is_earned);
  EXPECT_NEAR(decision.threshold, 0.2, 1e-12);
}

TEST(RiskControl, TestingNeedsMoreBlocksThanTheOnesWithoutAMiss) {
  const RiskDecision few = decide_by_testing(uniform_counts(44, {{}, {}}), {0.05, 0.1});
  EXPECT_FALSE(few.is_earned);
  EXPECT_EQ(few.needed_blocks, 45u);
  EXPECT_TRUE(decide_by_testing(uniform_counts(80, {{}, {}}), {0.05, 0.1}).is_earned);
  const RiskDecision half = decide_by_testing(uniform_counts(80, {{50, 0}}), {0.05, 0.1});
  EXPECT_FALSE(half.is_earned) << "a block that is answered half counts half";
  EXPECT_EQ(half.needed_blocks, 90u);
}

TEST(RiskControl, TestingStartsWhereHalfIsAnsweredAndStopsAtTheFirstThresholdThatFails) {
  const BlockCounts counts = uniform_counts(200, {{100, 0}, {90, 50}, {80, 0}, {60, 0}, {40, 30}});
  const RiskDecision decision = decide_by_testing(counts, {0.05, 0.1});
  EXPECT_TRUE(decision.is_earned);
  EXPECT_NEAR(decision.threshold, 0.3, 1e-12);
}

TEST(RiskControl, IsAtLeastAsStrictAsALooserShareThatIsEarned) {
  // 10 % is earned by 20 blocks where 6 % miss at most, 5 % is not; 4 % were seen at 0.1.
  const BlockCounts counts = uniform_counts(20, {{100, 4}, {100, 7}, {98, 3}, {40, 1}});
  ASSERT_NEAR(decide_conformally(counts, {0.1, 0.1}).threshold, 0.3, 1e-12);
  ASSERT_NEAR(decide_conformally(counts, {0.05, 0.1}).threshold, 0.1, 1e-12);
  const RiskDecision nested = decide_nested(&decide_conformally, counts, {0.05, 0.1});
  EXPECT_FALSE(nested.is_earned);
  EXPECT_NEAR(nested.threshold, 0.3, 1e-12);
  EXPECT_NEAR(nested.answered_share, 0.98, 1e-12);
}

TEST(RiskControl, ALargerAlphaNeverAnswersLess) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    AnsweredWorld world(seed);
    const BlockCounts counts = world.draw(5 + seed);
    double conformal = 2.0, tested = 2.0, empirical = 2.0;
    for (const double alpha : {0.01, 0.02, 0.05, 0.1, 0.2, 0.5}) {
      const RiskOptions options{alpha, 0.1};
      const auto now = [&](Decide decide) {
        return decide_nested(decide, counts, options).threshold;
      };
      EXPECT_LE(now(&decide_conformally), conformal) << seed << ", " << alpha;
      EXPECT_LE(now(&decide_by_testing), tested) << seed << ", " << alpha;
      EXPECT_LE(decide_empirically(counts, alpha).threshold, empirical) << seed << ", " << alpha;
      conformal = now(&decide_conformally);
      tested = now(&decide_by_testing);
      empirical = decide_empirically(counts, alpha).threshold;
    }
  }
}

// 1000 calibrations each: what they answer and miss in a further block, where they earn a promise.
struct Simulated {
  double earned_share = 0.0;    // of the calibrations
  double answered_share = 0.0;  // of all sites; nothing where the promise is not earned
  double missed_share = 0.0;    // of all sites
  double broken_share = 0.0;    // calibrations after which more than alpha of the answered miss

  void add(const RiskDecision& decision, double alpha) {
    constexpr double kTrial = 0.001;
    if (!decision.is_earned) return;
    const RiskDecision truth = AnsweredWorld::at(AnsweredWorld::truth(), decision.threshold);
    earned_share += kTrial;
    answered_share += kTrial * truth.answered_share;
    missed_share += kTrial * truth.answered_share * truth.miss_share;
    if (truth.miss_share > alpha) broken_share += kTrial;
  }
};

struct SimulatedCase {
  std::size_t block_count = 0;
  double alpha = 0.0;
  Simulated conformal, tested;
};

// The figures are in schemas/definitions.md, "Error model and choice of range".
const std::vector<SimulatedCase>& simulated_cases() {
  static const std::vector<SimulatedCase> cases = [] {
    std::vector<SimulatedCase> all;
    for (const std::size_t block_count : {20u, 40u, 100u}) {
      SimulatedCase strict{block_count, 0.05, {}, {}}, loose{block_count, 0.10, {}, {}};
      AnsweredWorld world(7);
      for (int trial = 0; trial < 1000; ++trial) {
        const BlockCounts counts = world.draw(block_count);
        for (SimulatedCase* each : {&strict, &loose}) {
          each->conformal.add(decide_conformally(counts, {each->alpha, 0.1}), each->alpha);
          each->tested.add(decide_by_testing(counts, {each->alpha, 0.1}), each->alpha);
        }
      }
      all.insert(all.end(), {strict, loose});
    }
    return all;
  }();
  return cases;
}

TEST(RiskControlSimulated, ConformallyKeepsThePromiseOnAverage) {
  for (const SimulatedCase& each : simulated_cases()) {
    const Simulated& result = each.conformal;
    EXPECT_LE(result.missed_share, each.alpha * result.answered_share) << each.block_count;
  }
  EXPECT_GE(simulated_cases().back().conformal.answered_share, 0.85) << "not by answering nothing";
}

TEST(RiskControlSimulated, TestingKeepsThePromiseAsOftenAsItSaysAndAnswersLess) {
  for (const SimulatedCase& each : simulated_cases()) {
    EXPECT_LE(each.tested.broken_share, 0.1) << each.block_count;
    EXPECT_LE(each.tested.answered_share, each.conformal.answered_share) << each.block_count;
  }
  EXPECT_GE(simulated_cases().back().tested.earned_share, 0.9);
}

}  // namespace
}  // namespace sightline

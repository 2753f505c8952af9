#include "passes/model/promise/calibration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "formats/base/random.h"

namespace sightline {
namespace {

// One threshold per entry of missed_per_threshold; each of `block_count` blocks of 100 sites misses
// that many.
Misses uniform_misses(std::size_t block_count, const std::vector<std::uint32_t>& missed) {
  Misses misses;
  misses.sites_in_block.assign(block_count, 100);
  for (std::size_t t = 0; t < missed.size(); ++t) {
    misses.thresholds.push_back(0.1 * static_cast<double>(t + 1));
    misses.in_block.emplace_back(block_count, missed[t]);
  }
  return misses;
}

// A world of exchangeable blocks: each block has its own level, each site its own number u, and a
// site misses at threshold t where u > level-dependent t. Blocks of 30 sites.
struct World {
  explicit World(std::uint64_t seed) : random(seed) {}
  Random random;
  std::vector<std::uint32_t> draw_block(const std::vector<double>& thresholds) {
    const double level = random.uniform(0.5, 1.5);
    std::vector<std::uint32_t> missed(thresholds.size(), 0);
    for (int site = 0; site < 30; ++site) {
      const double strength = std::pow(random.uniform(), 1.0 / level);
      for (std::size_t t = 0; t < thresholds.size(); ++t)
        if (strength > thresholds[t]) ++missed[t];
    }
    return missed;
  }
};

Misses draw_misses(World& world, std::size_t block_count) {
  Misses misses;
  for (int t = 1; t <= 100; ++t) misses.thresholds.push_back(0.01 * t);
  misses.sites_in_block.assign(block_count, 30);
  misses.in_block.assign(100, std::vector<std::uint32_t>(block_count, 0));
  for (std::size_t block = 0; block < block_count; ++block) {
    const std::vector<std::uint32_t> missed = world.draw_block(misses.thresholds);
    for (std::size_t t = 0; t < 100; ++t) misses.in_block[t][block] = missed[t];
  }
  return misses;
}

double loss_of_new_block(World& world, double threshold) {
  return world.draw_block({threshold})[0] / 30.0;
}

TEST(RiskControl, EmpiricallyTakesTheLeastThresholdThatMissesRarelyEnough) {
  const RiskDecision decision = decide_empirically(uniform_misses(2, {30, 5, 4, 1}), 0.05);
  EXPECT_NEAR(decision.threshold, 0.2, 1e-12);
  EXPECT_NEAR(decision.miss_share, 0.05, 1e-12);
  EXPECT_FALSE(decision.is_earned);
}

TEST(RiskControl, DoesNotTrustAThresholdWhoseStricterNeighbourMisses) {
  EXPECT_NEAR(decide_empirically(uniform_misses(2, {1, 30, 4, 1}), 0.05).threshold, 0.3, 1e-12);
}

TEST(RiskControl, TakesTheLeastMissesThereAreWhereNoneAreRareEnough) {
  const RiskDecision decision = decide_empirically(uniform_misses(2, {30, 12, 12, 12}), 0.05);
  EXPECT_NEAR(decision.threshold, 0.2, 1e-12);
  EXPECT_NEAR(decision.miss_share, 0.12, 1e-12);
}

TEST(RiskControl, ConformallyLeavesRoomForOneMoreBlock) {
  // n = 39: (39 L + 1) / 40 <= 0.05 needs L <= 1/39 = 2.56 %.
  const RiskDecision decision =
      decide_conformally(uniform_misses(39, {30, 5, 3, 2, 1}), {0.05, 0.1});
  EXPECT_TRUE(decision.is_earned);
  EXPECT_NEAR(decision.threshold, 0.4, 1e-12);
  EXPECT_EQ(decision.needed_blocks, 19u);
}

TEST(RiskControl, ConformallyNeedsNineteenBlocksForFivePercent) {
  EXPECT_FALSE(decide_conformally(uniform_misses(18, {0, 0}), {0.05, 0.1}).is_earned);
  EXPECT_TRUE(decide_conformally(uniform_misses(19, {0, 0}), {0.05, 0.1}).is_earned);
}

TEST(RiskControl, TestingNeedsFortyFiveBlocksForFivePercentAtNinetyPercentConfidence) {
  const RiskDecision few = decide_by_testing(uniform_misses(44, {0, 0}), {0.05, 0.1});
  EXPECT_FALSE(few.is_earned);
  EXPECT_EQ(few.needed_blocks, 45u);
  EXPECT_TRUE(decide_by_testing(uniform_misses(45, {0, 0}), {0.05, 0.1}).is_earned);
}

TEST(RiskControl, TestingStopsAtTheFirstThresholdThatFails) {
  const RiskDecision decision = decide_by_testing(uniform_misses(100, {0, 50, 0, 0}), {0.05, 0.1});
  EXPECT_NEAR(decision.threshold, 0.3, 1e-12);
}

TEST(RiskControl, FallsBackToWhatWasSeenWhereNothingIsEarned) {
  const Misses misses = uniform_misses(5, {30, 5, 1});
  const RiskDecision decision = decide_conformally(misses, {0.05, 0.1});
  EXPECT_FALSE(decision.is_earned);
  EXPECT_EQ(decision.threshold, decide_empirically(misses, 0.05).threshold);
}

TEST(RiskControl, ALargerAlphaNeverAsksForMore) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    World world(seed);
    const Misses misses = draw_misses(world, 60);
    double conformal = 2.0;
    double tested = 2.0;
    for (double alpha = 0.05; alpha < 0.5; alpha += 0.05) {
      const RiskDecision by_conformal = decide_conformally(misses, {alpha, 0.1});
      const RiskDecision by_testing = decide_by_testing(misses, {alpha, 0.1});
      ASSERT_TRUE(by_conformal.is_earned && by_testing.is_earned);
      EXPECT_LE(by_conformal.threshold, conformal);
      EXPECT_LE(by_testing.threshold, tested);
      EXPECT_GE(by_testing.threshold, by_conformal.threshold - 1e-12);
      conformal = by_conformal.threshold;
      tested = by_testing.threshold;
    }
  }
}

TEST(RiskControl, KeepsTheConformalPromiseOnBlocksItHasNotSeen) {
  constexpr double kAlpha = 0.1;
  constexpr int kTrials = 1000;
  World world(1);
  double loss = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const RiskDecision decision = decide_conformally(draw_misses(world, 25), {kAlpha, 0.1});
    ASSERT_TRUE(decision.is_earned);
    loss += loss_of_new_block(world, decision.threshold) / kTrials;
  }
  EXPECT_LE(loss, kAlpha);
  EXPECT_GE(loss, 0.4 * kAlpha);  // and is not bought by asking for everything
}

TEST(RiskControl, KeepsTheTestedPromiseAsOftenAsItSays) {
  constexpr double kAlpha = 0.1;
  constexpr double kDelta = 0.2;
  constexpr int kTrials = 200;
  World world(2);
  World judge(3);
  int broken = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const RiskDecision decision = decide_by_testing(draw_misses(world, 40), {kAlpha, kDelta});
    ASSERT_TRUE(decision.is_earned);
    double loss = 0.0;
    for (int block = 0; block < 300; ++block) {
      loss += loss_of_new_block(judge, decision.threshold) / 300.0;
    }
    if (loss > kAlpha) ++broken;
  }
  EXPECT_LE(broken, kDelta * kTrials);
}

}  // namespace
}  // namespace sightline

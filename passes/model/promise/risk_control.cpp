#include "passes/model/promise/risk_control.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "formats/base/check.h"
#include "formats/base/portable_math.h"

namespace sightline {
namespace {

// Sums of shares are exact to about 1e-15 a block; a bound that is met exactly must count as met.
constexpr double kRounding = 1e-12;

std::uint64_t total(const std::vector<std::uint32_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

double quotient(std::uint64_t part, std::uint64_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

// 1 where nothing is answered.
double miss_share(const BlockCounts& counts, std::size_t threshold) {
  const std::uint64_t answered = total(counts.answered[threshold]);
  return answered > 0 ? quotient(total(counts.missed[threshold]), answered) : 1.0;
}

RiskDecision at(const BlockCounts& counts, std::size_t threshold, bool is_earned,
                std::uint32_t needed_blocks) {
  const std::uint64_t answered = total(counts.answered[threshold]);
  RiskDecision decision{counts.thresholds[threshold], is_earned};
  decision.miss_share = answered > 0 ? miss_share(counts, threshold) : 0.0;
  decision.answered_share = quotient(answered, total(counts.sites_in_block));
  decision.needed_blocks = needed_blocks;
  return decision;
}

double share(const BlockCounts& counts, const std::vector<std::uint32_t>& of_blocks,
             std::size_t block) {
  return quotient(of_blocks[block], counts.sites_in_block[block]);
}

// Sum over blocks.
double sum_of_shares(const BlockCounts& counts, const std::vector<std::uint32_t>& of_blocks) {
  double sum = 0.0;
  for (std::size_t block = 0; block < of_blocks.size(); ++block) {
    sum += share(counts, of_blocks, block);
  }
  return sum;
}

// Of one block, at the loosest threshold: no stricter one answers more.
double most_answered(const BlockCounts& counts) {
  return sum_of_shares(counts, counts.answered.front()) /
         static_cast<double>(counts.sites_in_block.size());
}

std::uint32_t blocks_needed(double answered_blocks, const BlockCounts& counts) {
  const double each = most_answered(counts);
  return each > 0.0 ? static_cast<std::uint32_t>(std::ceil(answered_blocks / each - kRounding)) : 0;
}

// [threshold]: the quotient of decide_conformally.
std::vector<double> conformal_bounds(const BlockCounts& counts) {
  std::vector<std::uint32_t> worst(counts.sites_in_block.size(), 0);
  std::vector<double> bounds(counts.thresholds.size(), 0.0);
  for (std::size_t t = counts.thresholds.size(); t-- > 0;) {
    for (std::size_t block = 0; block < worst.size(); ++block) {
      worst[block] = std::max(worst[block], counts.missed[t][block]);
    }
    bounds[t] =
        (sum_of_shares(counts, worst) + 1.0) / (sum_of_shares(counts, counts.answered[t]) + 1.0);
  }
  return bounds;
}

double betting_p_value(const BlockCounts& counts, std::size_t threshold, double alpha) {
  constexpr int kStakes = 20;
  double wealth = 0.0;
  for (int i = 1; i <= kStakes; ++i) {
    const double stake = i / (kStakes * (1.0 - alpha));  // the largest loses all at one lost block
    double of_stake = 1.0;
    for (std::size_t block = 0; block < counts.sites_in_block.size(); ++block) {
      const double loss = share(counts, counts.missed[threshold], block) -
                          alpha * share(counts, counts.answered[threshold], block);
      of_stake *= 1.0 - stake * loss;
    }
    wealth += of_stake / kStakes;
  }
  return wealth > 0.0 ? std::min(1.0, 1.0 / wealth) : 1.0;
}

// The strictest that answers half of what the loosest answers.
std::size_t first_tested(const BlockCounts& counts) {
  std::size_t threshold = counts.thresholds.size() - 1;
  while (threshold > 0 && 2 * total(counts.answered[threshold]) < total(counts.answered.front())) {
    --threshold;
  }
  return threshold;
}

RiskDecision unearned(const BlockCounts& counts, double alpha, std::uint32_t needed_blocks) {
  RiskDecision decision = decide_empirically(counts, alpha);
  decision.needed_blocks = needed_blocks;
  return decision;
}

}  // namespace

RiskDecision decide_empirically(const BlockCounts& counts, double alpha) {
  SIGHTLINE_CHECK(!counts.thresholds.empty() && !counts.sites_in_block.empty());
  std::size_t chosen = 0;
  for (std::size_t t = 0; t < counts.thresholds.size(); ++t) {
    if (miss_share(counts, t) <= alpha + kRounding) return at(counts, t, false, 0);
    if (miss_share(counts, t) < miss_share(counts, chosen)) chosen = t;
  }
  return at(counts, chosen, false, 0);
}

RiskDecision decide_conformally(const BlockCounts& counts, const RiskOptions& options) {
  const std::vector<double> bounds = conformal_bounds(counts);
  const std::uint32_t needed = blocks_needed(1.0 / options.alpha - 1.0, counts);
  const auto earned = std::ranges::find_if(
      bounds, [&](double bound) { return bound <= options.alpha + kRounding; });
  if (earned == bounds.end()) return unearned(counts, options.alpha, needed);
  return at(counts, static_cast<std::size_t>(earned - bounds.begin()), true, needed);
}

RiskDecision decide_by_testing(const BlockCounts& counts, const RiskOptions& options) {
  const double needed = portable_log(options.delta) / portable_log(1.0 - options.alpha);
  const auto passes = [&](std::size_t threshold) {
    return betting_p_value(counts, threshold, options.alpha) <= options.delta;
  };
  const std::uint32_t needed_blocks = blocks_needed(needed, counts);
  std::size_t chosen = first_tested(counts);
  if (!passes(chosen)) return unearned(counts, options.alpha, needed_blocks);
  while (chosen > 0 && passes(chosen - 1)) --chosen;
  return at(counts, chosen, true, needed_blocks);
}

RiskDecision decide_nested(Decide decide, const BlockCounts& counts, const RiskOptions& options) {
  RiskDecision decision = decide(counts, options);
  for (const double alpha : {0.01, 0.02, 0.05, 0.1, 0.2, 0.5}) {
    if (decision.is_earned || alpha <= options.alpha) continue;
    const RiskDecision looser = decide(counts, {alpha, options.delta});
    if (!looser.is_earned) continue;
    if (looser.threshold <= decision.threshold) return decision;
    return {looser.threshold, false, looser.miss_share, looser.answered_share,
            decision.needed_blocks};
  }
  return decision;
}

}  // namespace sightline

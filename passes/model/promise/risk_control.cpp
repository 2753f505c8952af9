#include "passes/model/promise/risk_control.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "formats/base/check.h"
#include "formats/base/portable_math.h"

namespace sightline {
namespace {

// Sums of shares are exact to about 1e-15 a block; a bound that is met exactly must count as met.
constexpr double kRounding = 1e-12;

double block_loss(const Misses& misses, std::size_t threshold, std::size_t block) {
  return static_cast<double>(misses.in_block[threshold][block]) /
         static_cast<double>(misses.sites_in_block[block]);
}

// [threshold]: mean over blocks of the worst loss at this or any stricter threshold.
std::vector<double> monotone_block_risk(const Misses& misses) {
  const std::size_t block_count = misses.sites_in_block.size();
  std::vector<double> worst(block_count, 0.0);
  std::vector<double> risk(misses.thresholds.size(), 0.0);
  for (std::size_t t = misses.thresholds.size(); t-- > 0;) {
    for (std::size_t block = 0; block < block_count; ++block) {
      worst[block] = std::max(worst[block], block_loss(misses, t, block));
    }
    risk[t] = std::accumulate(worst.begin(), worst.end(), 0.0) / static_cast<double>(block_count);
  }
  return risk;
}

// Kullback-Leibler divergence of two coins.
double divergence(double p, double q) {
  double sum = 0.0;
  if (p > 0.0) sum += p * portable_log(p / q);
  if (p < 1.0) sum += (1.0 - p) * portable_log((1.0 - p) / (1.0 - q));
  return sum;
}

double p_value(double mean_loss, double alpha, std::size_t block_count) {
  if (mean_loss >= alpha) return 1.0;
  return portable_exp(-static_cast<double>(block_count) * divergence(mean_loss, alpha));
}

RiskDecision earned_at(const Misses& misses, std::size_t threshold, std::uint32_t needed_blocks) {
  return {misses.thresholds[threshold], true, miss_share(misses, threshold), needed_blocks};
}

RiskDecision unearned(const Misses& misses, double alpha, std::uint32_t needed_blocks) {
  RiskDecision decision = decide_empirically(misses, alpha);
  decision.needed_blocks = needed_blocks;
  return decision;
}

}  // namespace

double miss_share(const Misses& misses, std::size_t threshold) {
  const auto& missed = misses.in_block[threshold];
  const double missed_count =
      static_cast<double>(std::accumulate(missed.begin(), missed.end(), std::uint64_t{0}));
  const double site_count = static_cast<double>(std::accumulate(
      misses.sites_in_block.begin(), misses.sites_in_block.end(), std::uint64_t{0}));
  return missed_count / site_count;
}

RiskDecision decide_empirically(const Misses& misses, double alpha) {
  SIGHTLINE_CHECK(!misses.thresholds.empty() && !misses.sites_in_block.empty());
  std::size_t chosen = misses.thresholds.size() - 1;
  const double allowed = std::max(alpha, miss_share(misses, chosen)) + kRounding;
  while (chosen > 0 && miss_share(misses, chosen - 1) <= allowed) --chosen;
  return {misses.thresholds[chosen], false, miss_share(misses, chosen), 0};
}

RiskDecision decide_conformally(const Misses& misses, const RiskOptions& options) {
  const auto n = static_cast<double>(misses.sites_in_block.size());
  const auto needed = static_cast<std::uint32_t>(std::ceil(1.0 / options.alpha - 1.0 - kRounding));
  const std::vector<double> risk = monotone_block_risk(misses);
  const auto is_within = [&](std::size_t t) {
    return n / (n + 1.0) * risk[t] + 1.0 / (n + 1.0) <= options.alpha + kRounding;
  };
  std::size_t chosen = misses.thresholds.size() - 1;
  if (!is_within(chosen)) return unearned(misses, options.alpha, needed);
  while (chosen > 0 && is_within(chosen - 1)) --chosen;
  return earned_at(misses, chosen, needed);
}

RiskDecision decide_by_testing(const Misses& misses, const RiskOptions& options) {
  const std::size_t block_count = misses.sites_in_block.size();
  const auto needed = static_cast<std::uint32_t>(
      std::ceil(portable_log(options.delta) / portable_log(1.0 - options.alpha) - kRounding));
  const auto passes = [&](std::size_t t) {
    double loss = 0.0;
    for (std::size_t block = 0; block < block_count; ++block) {
      loss += block_loss(misses, t, block);
    }
    loss /= static_cast<double>(block_count);
    return p_value(loss, options.alpha, block_count) <= options.delta + kRounding;
  };
  std::size_t chosen = misses.thresholds.size() - 1;
  if (!passes(chosen)) return unearned(misses, options.alpha, needed);
  while (chosen > 0 && passes(chosen - 1)) --chosen;
  return earned_at(misses, chosen, needed);
}

}  // namespace sightline

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

// Risk control over answered places: how strict must the required probability be so that at most a
// share alpha of the answered places misses the limit? Places without an answer are not counted,
// but their share is stated. Decided on places that the trees never saw, and block by block: sites
// of one block see the same walls.

namespace sightline {

// What the rule does at each of some ascending thresholds, stricter ones last. A stricter threshold
// answers no more sites of any block.
struct BlockCounts {
  std::vector<double> thresholds;
  std::vector<std::uint32_t> sites_in_block;         // [block], none 0
  std::vector<std::vector<std::uint32_t>> answered;  // [threshold][block]: sites
  std::vector<std::vector<std::uint32_t>> missed;    // [threshold][block]: answered, over the limit
};

struct RiskOptions {
  double alpha = 0.05;  // share of the answered places that may miss
  double delta = 0.1;   // learn-then-test: how often the promise may fail
};

struct RiskDecision {
  double threshold = 0.0;
  bool is_earned = false;
  double miss_share = 0.0;          // of the answered calibration sites, at the threshold
  double answered_share = 0.0;      // of all calibration sites, at the threshold
  std::uint32_t needed_blocks = 0;  // with fewer, no threshold can earn the promise
};

// The least threshold at which the share of misses among answered sites is at most alpha; where
// there is none, the least at which that share is smallest. Promises nothing.
RiskDecision decide_empirically(const BlockCounts& counts, double alpha);

// Conformal risk control (Angelopoulos, Bates, Fisch, Lei, Schuster 2022) for a share of answered
// places: the least threshold with (sum of missed + 1) / (sum of answered + 1) <= alpha, where each
// of n exchangeable blocks adds its share of sites that are answered and missed (made monotone by
// its worst stricter threshold) and its share of answered sites; the ones are a further block,
// answered and missed everywhere. For that block E[missed] <= alpha E[answered], provided that the
// sites answered last miss no more rarely than alpha. Not earned: as decide_empirically.
RiskDecision decide_conformally(const BlockCounts& counts, const RiskOptions& options);

// Learn then test (Angelopoulos, Bates, Candes, Jordan, Lei 2021): thresholds are tested one after
// the other, the strictest that answers half of what the loosest answers first, until one fails.
// The p-value of "E[missed] > alpha E[answered]" is by betting (Waudby-Smith and Ramdas 2024): one
// over the mean, over 20 stakes, of the product over blocks of 1 - stake (missed - alpha answered),
// both as shares of the block's sites. With confidence 1 - delta E[missed] <= alpha E[answered].
// Not earned: as decide_empirically.
RiskDecision decide_by_testing(const BlockCounts& counts, const RiskOptions& options);

using Decide = RiskDecision (*)(const BlockCounts& counts, const RiskOptions& options);

// A decision such that a stricter alpha never answers more than a looser one that is 1, 2, 5, 10,
// 20 or 50 %: by `decide`; where it is not earned, the stricter one of its threshold and that of
// the next looser of these shares that is earned, without a promise.
RiskDecision decide_nested(Decide decide, const BlockCounts& counts, const RiskOptions& options);

}  // namespace sightline

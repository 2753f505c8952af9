#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/base/portable_math.h"
#include "formats/base/random.h"
#include "passes/model/promise/risk_control.h"
#include "passes/model/promise/selection.h"

namespace sightline {

// A road of exchangeable blocks of 15 sites with a cheap and a dear look: an eighth of the blocks
// is hard, a quarter harder than the rest. Log odds follow the road from site to site. Predictions
// are wrong by one amount for a whole block, and what makes a site miss lasts for some sites.
class AnsweredWorld {
 public:
  explicit AnsweredWorld(std::uint64_t seed) : random_(seed), thresholds_(tried_thresholds()) {}

  BlockCounts draw(std::size_t block_count) {
    const std::vector<std::uint32_t> none(block_count, 0);
    BlockCounts counts{thresholds_, std::vector<std::uint32_t>(block_count, kSites), {}, {}};
    counts.answered.assign(thresholds_.size(), none);
    counts.missed.assign(thresholds_.size(), none);
    for (std::size_t block = 0; block < block_count; ++block) add_block(block, counts);
    return counts;
  }

  // Shares at a threshold, of so many blocks that they are those of the world.
  static const BlockCounts& truth() {
    static const BlockCounts counts = AnsweredWorld(99).draw(20000);
    return counts;
  }
  static RiskDecision at(const BlockCounts& counts, double threshold) {
    const auto found = std::ranges::find(counts.thresholds, threshold);
    const auto t = static_cast<std::size_t>(found - counts.thresholds.begin());
    return decide_empirically(
        {{threshold}, counts.sites_in_block, {counts.answered[t]}, {counts.missed[t]}}, 0.0);
  }

 private:
  static constexpr std::uint32_t kSites = 15;

  static double share_of(double log_odds) { return 1.0 / (1.0 + portable_exp(-log_odds)); }

  void add_block(std::size_t block, BlockCounts& counts) {
    const double kind = random_.uniform();
    const double level = kind < 0.125 ? 0.0 : kind < 0.375 ? 3.0 : 5.5;
    const double prediction_error = 0.5 * random_.normal();
    double deviation = random_.normal();
    double luck = random_.uniform();
    for (std::uint32_t site = 0; site < kSites; ++site) {
      deviation = 0.8 * deviation + 0.6 * random_.normal();
      if (random_.uniform() < 0.3) luck = random_.uniform();
      const double dear = level + deviation;
      const double cheap = dear - 1.5;
      add_site(share_of(cheap + prediction_error), share_of(dear + prediction_error),
               luck > share_of(cheap), luck > share_of(dear), block, counts);
    }
  }

  void add_site(double p_cheap, double p_dear, bool cheap_misses, bool dear_misses,
                std::size_t block, BlockCounts& counts) const {
    for (std::size_t t = 0; t < thresholds_.size() && p_dear >= thresholds_[t]; ++t) {
      ++counts.answered[t][block];
      const bool misses = p_cheap >= thresholds_[t] ? cheap_misses : dear_misses;
      if (misses) ++counts.missed[t][block];
    }
  }

  Random random_;
  std::vector<double> thresholds_;
};

}  // namespace sightline

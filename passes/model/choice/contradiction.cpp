#include "passes/model/choice/contradiction.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "formats/base/check.h"
#include "formats/base/portable_math.h"

namespace sightline {
namespace {

constexpr double kBlock_m = 60.0;
constexpr double kUnlikely = 0.01;

struct Block {
  std::uint32_t answered = 0;
  std::uint32_t missed = 0;
};

// A stretch of route.
struct Run {
  double begin_m = 0.0;
  double end_m = 0.0;

  [[nodiscard]] double block_count() const {
    return std::max(1.0, std::floor((end_m - begin_m) / kBlock_m));
  }
  // Blocks of equal length.
  [[nodiscard]] std::uint32_t block_of(double s_m) const {
    if (end_m <= begin_m) return 0;
    const double place = (s_m - begin_m) / (end_m - begin_m) * block_count();
    return static_cast<std::uint32_t>(std::min(place, block_count() - 1.0));
  }
};

std::vector<std::size_t> judged_sites(const MeasuredError& measured, const Choice& choice) {
  std::vector<std::size_t> judged;
  for (std::size_t site = 0; site < measured.scan_of_site.size(); ++site) {
    if (measured.scan_of_site[site] >= 0 && choice.is_answered(site)) judged.push_back(site);
  }
  return judged;
}

}  // namespace

double binomial_tail(std::uint32_t count, std::uint32_t least, double p) {
  SIGHTLINE_CHECK(p > 0.0 && p < 1.0);
  if (least == 0) return 1.0;
  if (least > count) return 0.0;
  double log_term = least * portable_log(p) + (count - least) * portable_log(1.0 - p);
  for (std::uint32_t i = 1; i <= least; ++i) {
    log_term += portable_log(static_cast<double>(count - least + i) / i);
  }
  double term = portable_exp(log_term);
  double sum = 0.0;
  for (std::uint32_t i = least; i <= count; ++i) {
    sum += term;
    term *= static_cast<double>(count - i) / (i + 1.0) * p / (1.0 - p);
  }
  return std::min(1.0, sum);
}

std::optional<Contradiction> contradiction_of(const Sites& sites, const MeasuredError& measured,
                                              const Choice& choice, double limit_m, double alpha) {
  const std::vector<std::size_t> judged = judged_sites(measured, choice);
  if (judged.empty() || alpha <= 0.0) return std::nullopt;
  std::map<std::uint32_t, Run> runs;
  for (const std::size_t i : judged) {
    const Site& site = sites.sites[i];
    Run& run = runs.try_emplace(site.run, Run{site.s_m, site.s_m}).first->second;
    run = {std::min(run.begin_m, site.s_m), std::max(run.end_m, site.s_m)};
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, Block> blocks;
  for (const std::size_t i : judged) {
    const Site& site = sites.sites[i];
    Block& block = blocks[{site.run, runs.at(site.run).block_of(site.s_m)}];
    ++block.answered;
    if (measured.row(i, choice.range_index[i]).mean_m > limit_m) ++block.missed;
  }
  double missed_blocks = 0.0;
  std::size_t missed = 0;
  for (const auto& [of, block] : blocks) {
    missed_blocks += static_cast<double>(block.missed) / block.answered;
    missed += block.missed;
  }
  constexpr double kRounding = 1e-9;
  const Contradiction found{static_cast<std::uint32_t>(blocks.size()),
                            static_cast<std::uint32_t>(std::floor(missed_blocks + kRounding)),
                            1.0 - static_cast<double>(missed) / static_cast<double>(judged.size())};
  const double p_value = binomial_tail(found.block_count, found.missed_blocks, alpha);
  return p_value < kUnlikely ? std::optional(found) : std::nullopt;
}

}  // namespace sightline

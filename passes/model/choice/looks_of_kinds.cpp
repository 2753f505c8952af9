#include "passes/model/choice/looks_of_kinds.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "formats/base/parallel.h"

namespace sightline {
namespace {

constexpr double kRounding = 1e-12;  // shares that are equal may differ in their last bit
constexpr double kAnswerable = 0.8;  // of a kind's sites, that its best look must cover
constexpr double kBlock_m = 30.0;
constexpr double kLeastGain = 0.05;  // of the constant's cost
constexpr double kLevel = 1.645;     // standard errors: 5 %, one-sided
constexpr std::size_t kLeastBlocks = 8;

using LookOfKind = std::array<std::uint8_t, kPlaceKindCount>;
using SiteList = std::vector<std::size_t>;

// What a kind's sites show of each look.
struct KindSums {
  double site_count = 0.0;
  std::vector<double> miss_share;  // [look]
  bool is_answerable = false;
};
using SumsOfKinds = std::array<KindSums, kPlaceKindCount>;

// Of some drives, or of the map's own scans; 0 where none measured.
double miss_share_of(const LookEvidence& evidence, std::span<const LookErrors> drives,
                     const SiteList& sites, std::size_t look, double limit_m) {
  double count = 0.0;
  double missed = 0.0;
  for (const LookErrors& errors : drives) {
    for (const std::size_t site : sites) {
      if (errors.is_measured[site] == 0) continue;
      count += 1.0;
      missed += errors.error_m[evidence.shape.index(site, look)] > limit_m ? 1.0 : 0.0;
    }
  }
  return count > 0.0 ? missed / count : 0.0;
}

KindSums sums_of(const LookEvidence& evidence, const SiteList& sites, double limit_m) {
  KindSums sums;
  sums.site_count = static_cast<double>(sites.size());
  for (std::size_t look = 0; look < evidence.cost.size(); ++look) {
    sums.miss_share.push_back(
        std::max(miss_share_of(evidence, {&evidence.own, 1}, sites, look, limit_m),
                 miss_share_of(evidence, evidence.drives, sites, look, limit_m)));
  }
  const double least = std::ranges::min(sums.miss_share);
  sums.is_answerable = !sites.empty() && least <= 1.0 - kAnswerable + kRounding;
  return sums;
}

SumsOfKinds sums_of_kinds(const LookEvidence& evidence, const SiteList& sites, double limit_m) {
  std::array<SiteList, kPlaceKindCount> by_kind;
  for (const std::size_t site : sites) {
    by_kind[static_cast<std::size_t>(evidence.kinds[site])].push_back(site);
  }
  SumsOfKinds sums;
  for (std::size_t kind = 0; kind < sums.size(); ++kind) {
    sums[kind] = sums_of(evidence, by_kind[kind], limit_m);
  }
  const bool is_none = std::ranges::none_of(sums, &KindSums::is_answerable);
  for (KindSums& kind : sums) kind.is_answerable |= is_none && kind.site_count > 0.0;
  return sums;
}

// Over the sites of answerable kinds.
struct Total {
  double cost = 0.0;
  double missed = 0.0;
};
Total total_of(const LookEvidence& evidence, const SumsOfKinds& sums, const LookOfKind& looks) {
  Total total;
  for (std::size_t kind = 0; kind < sums.size(); ++kind) {
    if (!sums[kind].is_answerable) continue;
    total.cost += sums[kind].site_count * evidence.cost[looks[kind]];
    total.missed += sums[kind].site_count * sums[kind].miss_share[looks[kind]];
  }
  return total;
}

LookOfKind same_everywhere(std::size_t look) {
  LookOfKind looks;
  looks.fill(static_cast<std::uint8_t>(look));
  return looks;
}

// The cheapest of those that miss at most `miss_share`; else the one of fewest misses.
std::uint8_t best_constant(const LookEvidence& evidence, const SumsOfKinds& sums,
                           double miss_share) {
  double site_count = 0.0;
  for (const KindSums& kind : sums) site_count += kind.is_answerable ? kind.site_count : 0.0;
  std::vector<std::pair<double, std::size_t>> enough, all;  // (cost, look), (missed, look)
  for (std::size_t look = 0; look < evidence.cost.size(); ++look) {
    const Total total = total_of(evidence, sums, same_everywhere(look));
    all.emplace_back(total.missed, look);
    if (total.missed <= miss_share * site_count + kRounding) {
      enough.emplace_back(evidence.cost[look], look);
    }
  }
  return static_cast<std::uint8_t>(std::ranges::min(enough.empty() ? all : enough).second);
}

// Each kind's own look of least cost plus `weight` times misses.
LookOfKind weighted_looks(const LookEvidence& evidence, const SumsOfKinds& sums, double weight,
                          std::uint8_t otherwise) {
  LookOfKind looks = same_everywhere(otherwise);
  for (std::size_t kind = 0; kind < sums.size(); ++kind) {
    if (sums[kind].site_count == 0.0) continue;
    const std::vector<double>& missed = sums[kind].miss_share;
    std::vector<std::pair<double, std::size_t>> worth;
    for (std::size_t look = 0; look < missed.size(); ++look) {
      const double cost = evidence.cost[look];
      worth.emplace_back(sums[kind].is_answerable ? cost + weight * missed[look] : missed[look],
                         look);
    }
    looks[kind] = static_cast<std::uint8_t>(std::ranges::min(worth).second);
  }
  return looks;
}

struct Chosen {
  std::uint8_t everywhere = 0;
  LookOfKind looks{};
  double weight = 0.0;  // cost of a miss
};

// Least cost at no more misses than the constant's. A weight of 10 to 1e8 points for a miss.
Chosen choose_on(const LookEvidence& evidence, const SumsOfKinds& sums, double miss_share) {
  constexpr double kFactor = 1.333521432163324;  // eight steps are a power of ten
  Chosen chosen;
  chosen.everywhere = best_constant(evidence, sums, miss_share);
  chosen.looks = weighted_looks(evidence, sums, 1e9, chosen.everywhere);
  LookOfKind constant = same_everywhere(chosen.everywhere);
  for (std::size_t kind = 0; kind < sums.size(); ++kind) {
    if (!sums[kind].is_answerable) constant[kind] = chosen.looks[kind];
  }
  const Total budget = total_of(evidence, sums, constant);
  Total best = budget;
  chosen.looks = constant;
  double weight = 10.0;
  for (int step = 0; step <= 56; ++step, weight *= kFactor) {
    const LookOfKind looks = weighted_looks(evidence, sums, weight, chosen.everywhere);
    const Total total = total_of(evidence, sums, looks);
    if (total.missed > budget.missed + kRounding || total.cost >= best.cost) continue;
    best = total;
    chosen.looks = looks;
    chosen.weight = weight;
  }
  return chosen;
}

// [block]: its sites, in the order of the route.
std::vector<SiteList> blocks_of(const LookEvidence& evidence) {
  std::map<std::pair<std::uint32_t, std::int64_t>, SiteList> blocks;
  for (std::size_t site = 0; site < evidence.route.size(); ++site) {
    const RoutePoint& at = evidence.route[site];
    blocks[{at.run, static_cast<std::int64_t>(std::floor(at.s_m / kBlock_m))}].push_back(site);
  }
  std::vector<SiteList> list;
  for (auto& [key, sites] : blocks) list.push_back(std::move(sites));
  return list;
}

SiteList every_second(const std::vector<SiteList>& blocks, std::size_t first) {
  SiteList sites;
  for (std::size_t block = first; block < blocks.size(); block += 2) {
    sites.insert(sites.end(), blocks[block].begin(), blocks[block].end());
  }
  return sites;
}

// What the looks of kinds cost more than the constant in blocks that chose neither, the constant's
// cost being 1 a site.
struct Judged {
  std::vector<double> cost;   // [block]
  std::vector<double> value;  // [block]: with misses, weighted
  double site_count = 0.0;
};

void judge_block(const LookEvidence& evidence, const SiteList& sites, double limit_m,
                 const Chosen& chosen, const SumsOfKinds& sums, Judged& judged) {
  const double unit = evidence.cost[chosen.everywhere];
  const SumsOfKinds here = sums_of_kinds(evidence, sites, limit_m);
  double cost = 0.0;
  double missed = 0.0;
  for (std::size_t kind = 0; kind < here.size(); ++kind) {
    if (!sums[kind].is_answerable) continue;
    const KindSums& of = here[kind];
    if (of.site_count == 0.0) continue;
    const std::uint8_t look = chosen.looks[kind];
    cost += of.site_count * (evidence.cost[look] - unit) / unit;
    missed += of.site_count * (of.miss_share[look] - of.miss_share[chosen.everywhere]);
    judged.site_count += of.site_count;
  }
  judged.cost.push_back(cost);
  judged.value.push_back(cost + missed * chosen.weight / unit);
}

// Whether the mean is below 0 at the level.
bool is_below_zero(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  const double mean = ordered_sum(values) / count;
  std::vector<double> squares;
  for (const double value : values) squares.push_back((value - mean) * (value - mean));
  const double deviation = std::sqrt(ordered_sum(squares) / (count - 1.0));
  return mean < 0.0 && -mean * std::sqrt(count) >= kLevel * deviation;
}

bool is_proven_cheaper(const LookEvidence& evidence, double limit_m, double miss_share) {
  const std::vector<SiteList> blocks = blocks_of(evidence);
  if (evidence.is_simulated || blocks.size() < kLeastBlocks) return false;
  Judged judged;
  for (const std::size_t half : {0, 1}) {
    const SumsOfKinds sums = sums_of_kinds(evidence, every_second(blocks, half), limit_m);
    const Chosen chosen = choose_on(evidence, sums, miss_share);
    for (std::size_t block = 1 - half; block < blocks.size(); block += 2) {
      judge_block(evidence, blocks[block], limit_m, chosen, sums, judged);
    }
  }
  return ordered_sum(judged.cost) < -kLeastGain * judged.site_count && is_below_zero(judged.value);
}

}  // namespace

KindLooks choose_kind_looks(const LookEvidence& evidence, double limit_m, double miss_share) {
  SiteList all;
  for (std::size_t site = 0; site < evidence.kinds.size(); ++site) all.push_back(site);
  const SumsOfKinds sums = sums_of_kinds(evidence, all, limit_m);
  const Chosen chosen = choose_on(evidence, sums, miss_share);
  const bool differs = is_proven_cheaper(evidence, limit_m, miss_share);
  KindLooks looks{chosen.everywhere, differs ? chosen.looks : same_everywhere(chosen.everywhere)};
  double within = 0.0;
  for (std::size_t kind = 0; kind < sums.size(); ++kind) {
    if (sums[kind].site_count == 0.0) continue;
    within += sums[kind].site_count * (1.0 - sums[kind].miss_share[looks.of_kind[kind]]);
  }
  looks.coverage = all.empty() ? 0.0 : within / static_cast<double>(all.size());
  return looks;
}

}  // namespace sightline

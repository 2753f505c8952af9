#include "passes/weakness/weak_stretches.h"

#include <algorithm>
#include <limits>
#include <string>
#include <tuple>

namespace sightline {
namespace {

void take_better(const PredictedError& predicted, std::size_t site, std::size_t limit,
                 BestLook& best) {
  for (std::size_t look = 0; look < predicted.looks.size(); ++look) {
    const double error_m = predicted.mean(site, look);
    if (!(error_m < best.error_m)) continue;
    best.look = predicted.looks[look];
    best.error_m = error_m;
    best.probability = predicted.probability(site, look, limit);
  }
}

bool is_unmet(const CompiledMap& map, std::size_t site, std::size_t limit) {
  const auto says_so = [&](const RangeTable& table) {
    return (table.flags_of(site, limit) & kUnmet) != 0;
  };
  return says_so(map.ranges) && (!map.looks || says_so(map.looks->ranges));
}

bool is_worse(const BestLook& a, const BestLook& b) {
  return std::tuple(!a.is_unmet, a.margin) < std::tuple(!b.is_unmet, b.margin);
}

void add_site(const Sites& sites, const std::vector<BestLook>& best, std::size_t site,
              WeakStretch& stretch) {
  stretch.last_site = site;
  stretch.to_m = sites.sites[site].s_m;
  stretch.unmet_count += best[site].is_unmet ? 1 : 0;
  if (!is_worse(best[site], stretch.worst)) return;
  stretch.worst_site = site;
  stretch.worst = best[site];
}

WeakStretch begin_at(const Sites& sites, const std::vector<BestLook>& best, std::size_t site) {
  const Site& at = sites.sites[site];
  WeakStretch stretch{at.run, site, site, at.s_m, at.s_m, 0, site, best[site]};
  stretch.unmet_count = best[site].is_unmet ? 1 : 0;
  return stretch;
}

}  // namespace

Result<std::size_t> limit_of(const CompiledMap& map, double limit_m) {
  std::string known;
  for (std::size_t i = 0; i < map.ranges.promises.size(); ++i) {
    if (limit_m == 0.0 || map.ranges.promises[i].limit_m == limit_m) return i;
    known += (i == 0 ? "" : ", ") + format_double(map.ranges.promises[i].limit_m);
  }
  return Error{ErrorCode::kBadArgument, concat("found the limit ", format_double(limit_m),
                                               " m, expected one of the map's: ", known, " m")};
}

std::vector<BestLook> best_looks(const CompiledMap& map, std::size_t limit) {
  const double limit_m = map.ranges.promises[limit].limit_m;
  std::vector<BestLook> best(map.sites.sites.size());
  for (std::size_t site = 0; site < best.size(); ++site) {
    BestLook& found = best[site];
    found.error_m = std::numeric_limits<double>::infinity();
    take_better(map.predicted, site, limit, found);
    if (map.looks) take_better(map.looks->predicted, site, limit, found);
    found.margin = 1.0 - found.error_m / limit_m;
    found.is_unmet = is_unmet(map, site, limit);
  }
  return best;
}

std::vector<WeakStretch> weak_stretches(const Sites& sites, const std::vector<BestLook>& best,
                                        const WeakStretchOptions& options) {
  std::vector<WeakStretch> found;
  for (std::size_t site = 0; site < best.size(); ++site) {
    if (!best[site].is_unmet && best[site].margin >= options.least_margin) continue;
    const Site& at = sites.sites[site];
    const bool continues = !found.empty() && found.back().run == at.run &&
                           at.s_m - found.back().to_m <= options.join_m &&
                           at.s_m - found.back().from_m <= options.longest_m;
    if (continues) {
      add_site(sites, best, site, found.back());
    } else {
      found.push_back(begin_at(sites, best, site));
    }
  }
  std::ranges::stable_sort(
      found, [](const WeakStretch& a, const WeakStretch& b) { return is_worse(a.worst, b.worst); });
  return found;
}

}  // namespace sightline

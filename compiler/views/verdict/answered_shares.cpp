#include "compiler/views/verdict/answered_shares.h"

#include <algorithm>
#include <vector>

namespace sightline {
namespace {

PointGrid sites_in_the_plane(const Sites& sites) {
  std::vector<Eigen::Vector3d> places_m;
  for (const Site& site : sites.sites) {
    places_m.emplace_back(site.p_map_m.x(), site.p_map_m.y(), 0.0);
  }
  return PointGrid(places_m);
}

const RangeTable* table_of(const CompiledMap& map, AnswerKind kind) {
  if (kind == AnswerKind::kRange) return &map.ranges;
  return map.looks ? &map.looks->ranges : nullptr;
}

}  // namespace

AnsweredShares::AnsweredShares(const CompiledMap& map)
    : map_(map), sites_(sites_in_the_plane(map.sites)) {}

void AnsweredShares::add_site(AnswerKind kind, double limit_m, std::size_t site, double error_m) {
  const RangeTable* const table = table_of(map_, kind);
  if (table == nullptr || site >= table->site_count) return;
  const auto promise = std::ranges::find(table->promises, limit_m, &LimitPromise::limit_m);
  if (promise == table->promises.end()) return;
  const auto limit = static_cast<std::size_t>(promise - table->promises.begin());
  if ((table->flags_of(site, limit) & kUnmet) != 0) return;
  Count& count = counts_[{kind, limit_m}];
  ++count.all;
  if (error_m <= limit_m) ++count.within;
}

void AnsweredShares::add_scan(AnswerKind kind, double limit_m, const Eigen::Vector2d& p_map_m,
                              double error_m) {
  const std::optional<NearPoint> site =
      sites_.nearest({p_map_m.x(), p_map_m.y(), 0.0}, map_.reach_m);
  if (site) add_site(kind, limit_m, site->index, error_m);
}

double answered_coverage_of_looks(const CompiledMap& map, std::size_t limit, double coverage) {
  const auto sites = static_cast<double>(map.sites.sites.size());
  const double answered = sites - static_cast<double>(map.looks->quality[limit].unmet_count);
  return answered > 0.0 ? std::min(1.0, coverage * sites / answered) : 1.0;
}

double AnsweredShares::share(AnswerKind kind, double limit_m) const {
  const auto found = counts_.find({kind, limit_m});
  if (found == counts_.end()) return 1.0;
  return static_cast<double>(found->second.within) / static_cast<double>(found->second.all);
}

}  // namespace sightline

#include "formats/map/diff/diff_stretches.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace sightline {
namespace {

// Sites, ascending, cut where the route or what changed has a gap, and where a piece gets too long.
template <class RowOf>
std::vector<std::vector<std::uint32_t>> cut(const std::set<std::uint32_t>& sites,
                                            const MapDiffOptions& options, const RowOf& row_of) {
  std::vector<std::vector<std::uint32_t>> pieces;
  const SiteRow* previous = nullptr;
  for (const std::uint32_t site : sites) {
    const SiteRow& row = row_of(site);
    const bool goes_on = previous != nullptr && previous->run == row.run &&
                         row.s_m - previous->s_m <= options.join_m &&
                         row.s_m - row_of(pieces.back().front()).s_m < options.longest_m;
    if (!goes_on) pieces.emplace_back();
    pieces.back().push_back(site);
    previous = &row;
  }
  return pieces;
}

// Sites around which the place changed: within the window along the route, enough of the NDs did.
std::set<std::uint32_t> sites_of_changed_places(const ComparedSites& compared, const NdsBySite& nds,
                                                const MapDiffOptions& options) {
  constexpr std::uint64_t kFewest = 20;  // fewer are a parked car
  const auto row_of = [&](std::uint32_t site) -> const SiteRow& {
    return *compared.after.at(site).row;
  };
  const auto is_near = [&](std::uint32_t site, std::uint32_t other) {
    const SiteRow& a = row_of(site);
    const SiteRow& b = row_of(other);
    return a.run == b.run && std::abs(a.s_m - b.s_m) <= options.window_m;
  };
  std::set<std::uint32_t> found;
  auto first = nds.begin();  // of the window, which moves along with the site
  for (auto site = nds.begin(); site != nds.end(); ++site) {
    while (!is_near(site->first, first->first)) ++first;
    std::uint64_t changed = 0;
    std::uint64_t stayed = 0;
    for (auto other = first; other != nds.end() && is_near(site->first, other->first); ++other) {
      changed += other->second.changed();
      stayed += other->second.stayed;
    }
    const auto all = static_cast<double>(changed + stayed);
    if (changed >= kFewest && static_cast<double>(changed) >= options.changed_share * all) {
      found.insert(site->first);
    }
  }
  return found;
}

Stretch begin_stretch(const SiteRow& first, const SiteRow& last) {
  Stretch stretch;
  stretch.run = first.run;
  stretch.begin_s_m = first.s_m;
  stretch.end_s_m = last.s_m;
  stretch.first_site = first.site;
  stretch.last_site = last.site;
  return stretch;
}

void add_answers(const std::vector<AnswerDiff>& answers, std::vector<StretchLimit>& limits) {
  for (std::size_t i = 0; i < answers.size(); ++i) {
    limits[i].mean_range_before_m += answers[i].before.range_m;
    limits[i].mean_range_after_m += answers[i].after.range_m;
    answers[i].add_to(limits[i]);
  }
}

// All sites from the first to the last one: those between them belong to the stretch too.
Stretch stretch_after(const std::vector<std::uint32_t>& piece, const CompiledMap& after,
                      std::size_t limits, const ComparedSites& compared, const NdsBySite& nds) {
  Stretch stretch =
      begin_stretch(*compared.after.at(piece.front()).row, *compared.after.at(piece.back()).row);
  stretch.limits.resize(limits);
  std::uint32_t known = 0;
  const auto end = compared.after.upper_bound(piece.back());
  for (auto site = compared.after.lower_bound(piece.front()); site != end; ++site) {
    stretch.line_world_m.push_back(site->second.row->p_m + after.ndt.frame.origin_world_m);
    add_answers(site->second.answers, stretch.limits);
    known += site->second.is_known_before ? 1 : 0;
    stretch.sites_added += site->second.is_known_before ? 0 : 1;
    const auto near = nds.find(site->first);
    if (near == nds.end()) continue;
    stretch.nds_added += near->second.added;
    stretch.nds_removed += near->second.removed;
    stretch.nds_moved += near->second.moved;
  }
  for (StretchLimit& limit : stretch.limits) {
    if (known == 0) break;
    limit.mean_range_before_m /= known;
    limit.mean_range_after_m /= known;
  }
  return stretch;
}

Stretch stretch_before(const std::vector<std::uint32_t>& piece, const CompiledMap& before,
                       std::size_t limits, const ComparedSites& compared) {
  Stretch stretch = begin_stretch(*compared.only_before.at(piece.front()),
                                  *compared.only_before.at(piece.back()));
  stretch.is_of_old_map = true;
  stretch.limits.resize(limits);
  stretch.sites_removed = static_cast<std::uint32_t>(piece.size());
  for (const std::uint32_t site : piece) {
    stretch.line_world_m.push_back(compared.only_before.at(site)->p_m +
                                   before.ndt.frame.origin_world_m);
  }
  return stretch;
}

}  // namespace

void find_stretches(const CompiledMap& before, const CompiledMap& after,
                    const ComparedSites& compared, const NdsBySite& nds, MapDiff& diff) {
  std::set<std::uint32_t> marked;
  std::set<std::uint32_t> removed;
  for (const SiteDiff& site : diff.sites) {
    (site.change == SiteChange::kRemoved ? removed : marked).insert(site.site);
  }
  const std::set<std::uint32_t> places = sites_of_changed_places(compared, nds, diff.options);
  marked.insert(places.begin(), places.end());
  const std::size_t limits = common_limits(before, after).size();
  const auto row_after = [&](std::uint32_t site) -> const SiteRow& {
    return *compared.after.at(site).row;
  };
  for (const std::vector<std::uint32_t>& piece : cut(marked, diff.options, row_after)) {
    diff.stretches.push_back(stretch_after(piece, after, limits, compared, nds));
    diff.stretches.back().has_changed_place =
        std::ranges::any_of(piece, [&](std::uint32_t site) { return places.contains(site); });
  }
  diff.nds_scattered = diff.nds.size() - diff.nds_off_route;
  for (const Stretch& stretch : diff.stretches) {
    diff.nds_scattered -= stretch.nds_added + stretch.nds_removed + stretch.nds_moved;
  }
  const auto row_before = [&](std::uint32_t site) -> const SiteRow& {
    return *compared.only_before.at(site);
  };
  for (const std::vector<std::uint32_t>& piece : cut(removed, diff.options, row_before)) {
    diff.stretches.push_back(stretch_before(piece, before, limits, compared));
  }
}

}  // namespace sightline

#include "formats/map/diff/diff_sites.h"

#include <algorithm>

namespace sightline {
namespace {

Eigen::Vector3d origin_m(const MapSide& side) { return side.card().ndt.frame.origin_world_m; }

// Equal bytes of a layer are equal answers only where ranges, limits and reach are equal too.
bool has_same_terms(const CompiledMap& before, const CompiledMap& after) {
  const auto limit_of = [](const LimitPromise& promise) { return promise.limit_m; };
  return before.ranges.looks == after.ranges.looks && before.reach_m == after.reach_m &&
         std::ranges::equal(before.ranges.promises, after.ranges.promises, {}, limit_of, limit_of);
}

Result<ComparedSite> compare_site(const SiteRow& row, const Eigen::Vector3d& shift_m,
                                  MapSide& before, const CommonLimits& limits) {
  SIGHTLINE_ASSIGN(const NearestSite nearest,
                   before.nearest(row.p_m + shift_m, before.card().reach_m));
  ComparedSite site{&row, nearest.row != nullptr, {}, nearest.distance_m, 0.0, 0.0};
  if (nearest.row == nullptr) return site;
  site.longest_points_before = nearest.row->longest_virtual_points;
  site.longest_points_after = row.longest_virtual_points;
  for (const auto& [old_limit, new_limit] : limits) {
    site.answers.push_back({nearest.row->answers[old_limit], row.answers[new_limit]});
  }
  return site;
}

SiteDiff site_diff(SiteChange change, const SiteRow& row, const Eigen::Vector3d& origin) {
  SiteDiff site;
  site.change = change;
  site.site = row.site;
  site.run = row.run;
  site.s_m = row.s_m;
  site.p_world_m = row.p_m + origin;
  return site;
}

std::vector<LimitDiff> limits_of(const CompiledMap& before, const CompiledMap& after) {
  std::map<double, LimitDiff> limits;
  for (std::size_t i = 0; i < before.quality.size(); ++i) {
    limits[before.ranges.promises[i].limit_m].before = before.quality[i];
  }
  for (std::size_t i = 0; i < after.quality.size(); ++i) {
    limits[after.ranges.promises[i].limit_m].after = after.quality[i];
  }
  std::vector<LimitDiff> sorted;
  for (auto& [limit_m, limit] : limits) {
    limit.limit_m = limit_m;
    sorted.push_back(limit);
  }
  return sorted;
}

void count_answers(const std::vector<AnswerDiff>& answers, std::vector<LimitDiff>& limits) {
  std::size_t common = 0;
  for (LimitDiff& limit : limits) {
    if (!limit.is_common()) continue;
    answers[common++].add_to(limit);
  }
}

// Work of each limit, summed up over sites that both maps know.
struct Work {
  double before = 0.0;
  double after = 0.0;
};
void find_work(const ComparedSites& compared, std::vector<LimitDiff>& limits) {
  std::vector<Work> chosen(limits.size());
  Work longest;
  for (const auto& [id, site] : compared.after) {
    if (!site.is_known_before) continue;
    longest.before += site.longest_points_before;
    longest.after += site.longest_points_after;
    for (std::size_t i = 0; i < site.answers.size(); ++i) {
      chosen[i].before += site.answers[i].before.virtual_points;
      chosen[i].after += site.answers[i].after.virtual_points;
    }
  }
  std::size_t common = 0;
  for (LimitDiff& limit : limits) {
    if (!limit.is_common()) continue;
    const Work& work = chosen[common++];
    if (longest.before > 0.0) limit.work_before = work.before / longest.before;
    if (longest.after > 0.0) limit.work_after = work.after / longest.after;
  }
}

}  // namespace

ComparedSite same_site(const SiteRow& row, const CommonLimits& limits) {
  ComparedSite site{&row, true, {}, 0.0, row.longest_virtual_points, row.longest_virtual_points};
  for (const auto& [old_limit, new_limit] : limits) {
    site.answers.push_back({row.answers[new_limit], row.answers[new_limit]});
  }
  return site;
}

CommonLimits common_limits(const CompiledMap& before, const CompiledMap& after) {
  CommonLimits common;
  for (std::size_t i = 0; i < before.ranges.promises.size(); ++i) {
    for (std::size_t j = 0; j < after.ranges.promises.size(); ++j) {
      if (before.ranges.promises[i].limit_m == after.ranges.promises[j].limit_m) {
        common.emplace_back(i, j);
      }
    }
  }
  return common;
}

Result<ComparedSites> compare_sites(MapSide& before, MapSide& after,
                                    std::span<const TilePair> tiles) {
  const CommonLimits limits = common_limits(before.card(), after.card());
  const bool same_terms = has_same_terms(before.card(), after.card());
  const Eigen::Vector3d to_before_m = origin_m(after) - origin_m(before);
  ComparedSites compared;
  for (const TilePair& pair : tiles) {
    const bool is_same = pair.has_same_sites && same_terms;
    if (is_same && pair.has_same_nds) continue;
    if (pair.after) {
      SIGHTLINE_ASSIGN(const TileSites* sites, after.sites(*pair.after));
      for (const SiteRow& row : sites->rows) {
        SIGHTLINE_ASSIGN(ComparedSite site, is_same
                                                ? Result<ComparedSite>(same_site(row, limits))
                                                : compare_site(row, to_before_m, before, limits));
        compared.after[row.site] = std::move(site);
      }
    }
    if (!pair.before || is_same) continue;
    SIGHTLINE_ASSIGN(const TileSites* sites, before.sites(*pair.before));
    for (const SiteRow& row : sites->rows) {
      SIGHTLINE_ASSIGN(const NearestSite now,
                       after.nearest(row.p_m - to_before_m, after.card().reach_m));
      if (now.row == nullptr) compared.only_before[row.site] = &row;
    }
  }
  return compared;
}

void count_sites(const CompiledMap& before, const CompiledMap& after, const ComparedSites& compared,
                 MapDiff& diff) {
  diff.limits = limits_of(before, after);
  find_work(compared, diff.limits);
  for (const auto& [id, site] : compared.after) {
    if (!site.is_known_before) {
      diff.sites.push_back(
          site_diff(SiteChange::kAdded, *site.row, after.ndt.frame.origin_world_m));
      ++diff.sites_added;
      continue;
    }
    count_answers(site.answers, diff.limits);
    if (std::ranges::none_of(site.answers, &AnswerDiff::is_different)) continue;
    diff.sites.push_back(
        site_diff(SiteChange::kChanged, *site.row, after.ndt.frame.origin_world_m));
    diff.sites.back().distance_m = site.distance_m;
    diff.sites.back().answers = site.answers;
  }
  for (const auto& [id, row] : compared.only_before) {
    diff.sites.push_back(site_diff(SiteChange::kRemoved, *row, before.ndt.frame.origin_world_m));
    ++diff.sites_removed;
  }
}

}  // namespace sightline

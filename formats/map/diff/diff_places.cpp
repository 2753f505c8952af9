#include "formats/map/diff/diff_places.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "map_generated.h"

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
                   before.nearest(row.p_m + shift_m, before.card().reach_m, MapSide::Level::kSame));
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
    if (limit.is_common()) answers[common++].add_to(limit);
  }
}

// Work of one limit, summed over sites that both maps know.
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

using Blocks = flatbuffers::Vector<flatbuffers::Offset<schema::Block>>;

bool is_same(const schema::Digest& a, const schema::Digest& b) {
  return std::equal(a.bytes()->begin(), a.bytes()->end(), b.bytes()->begin());
}

bool is_same(const schema::Block* before, const schema::Block* after) {
  if (before == nullptr || after == nullptr) return before == after;
  return before->version() == after->version() && before->row_count() == after->row_count() &&
         is_same(*before->raw_digest(), *after->raw_digest());
}

const schema::Tile* tile_at(const MapSide& side, std::optional<std::uint32_t> tile) {
  return tile ? side.container().directory->tiles()->Get(*tile) : nullptr;
}

// Whole steps in `distance_m`, if it is a whole number of them that a key can hold.
std::optional<std::int32_t> whole_steps(double distance_m, double step_m) {
  const double steps = std::round(distance_m / step_m);
  constexpr double kMost = 0x1.0p30;
  if (!(std::abs(steps) < kMost) || steps * step_m != distance_m) return std::nullopt;
  return static_cast<std::int32_t>(steps);
}

std::map<TileKey, TilePair> tiles_by_place(const MapSide& before, const MapSide& after,
                                           const GridShift& shift) {
  std::map<TileKey, TilePair> pairs;
  for (std::uint32_t tile = 0; tile < after.tile_count(); ++tile) {
    pairs[after.tile_key(tile)].after = tile;
  }
  for (std::uint32_t tile = 0; tile < before.tile_count(); ++tile) {
    const TileKey key = before.tile_key(tile);
    const std::int64_t x = std::int64_t{key.x} + shift.tiles.x;
    const std::int64_t y = std::int64_t{key.y} + shift.tiles.y;
    pairs[{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)}].before = tile;
  }
  return pairs;
}

void compare(const MapSide& before, const MapSide& after, TilePair& pair) {
  if (!pair.before || !pair.after) return;
  const auto same_layer = [&](std::string_view name) {
    return is_same(find_layer(before.container(), *pair.before, name),
                   find_layer(after.container(), *pair.after, name));
  };
  pair.has_same_digest =
      is_same(*tile_at(before, pair.before)->digest(), *tile_at(after, pair.after)->digest());
  pair.has_same_nds = same_layer(kNdtLayer);
  pair.has_same_sites = same_layer(kRangeLayer);
}

void count_blocks(const Blocks* before, const Blocks* after,
                  std::map<std::string, BlockDiff>& counts) {
  std::map<std::string, std::pair<const schema::Block*, const schema::Block*>> names;
  if (before != nullptr) {
    for (const schema::Block* block : *before) names[block->name()->str()].first = block;
  }
  if (after != nullptr) {
    for (const schema::Block* block : *after) names[block->name()->str()].second = block;
  }
  for (const auto& [name, blocks] : names) {
    if (is_derived(name)) continue;  // follows from the others
    BlockDiff& count = counts[name];
    count.name = name;
    count.is_required |= (blocks.second != nullptr ? blocks.second : blocks.first)->is_required();
    if (blocks.first == nullptr) {
      ++count.added;
    } else if (blocks.second == nullptr) {
      ++count.removed;
    } else {
      ++(is_same(blocks.first, blocks.second) ? count.same : count.changed);
    }
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
    const bool stayed = pair.has_same_sites && same_terms;
    if (stayed && pair.has_same_nds) continue;
    if (pair.after) {
      SIGHTLINE_ASSIGN(const TileSites* sites, after.sites(*pair.after));
      for (const SiteRow& row : sites->rows) {
        SIGHTLINE_ASSIGN(ComparedSite site, stayed
                                                ? Result<ComparedSite>(same_site(row, limits))
                                                : compare_site(row, to_before_m, before, limits));
        compared.after[row.site] = std::move(site);
      }
    }
    if (!pair.before || stayed) continue;
    SIGHTLINE_ASSIGN(const TileSites* sites, before.sites(*pair.before));
    for (const SiteRow& row : sites->rows) {
      SIGHTLINE_ASSIGN(
          const NearestSite now,
          after.nearest(row.p_m - to_before_m, after.card().reach_m, MapSide::Level::kSame));
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

std::optional<GridShift> grid_shift(const CompiledMap& before, const CompiledMap& after) {
  if (before.ndt.cell_m != after.ndt.cell_m || before.ndt.tile_m != after.ndt.tile_m) return {};
  const Eigen::Vector3d shift_m = before.ndt.frame.origin_world_m - after.ndt.frame.origin_world_m;
  const std::optional<std::int32_t> tiles_x = whole_steps(shift_m.x(), after.ndt.tile_m);
  const std::optional<std::int32_t> tiles_y = whole_steps(shift_m.y(), after.ndt.tile_m);
  const std::optional<std::int32_t> cells_x = whole_steps(shift_m.x(), after.ndt.cell_m);
  const std::optional<std::int32_t> cells_y = whole_steps(shift_m.y(), after.ndt.cell_m);
  const std::optional<std::int32_t> cells_z = whole_steps(shift_m.z(), after.ndt.cell_m);
  if (!tiles_x || !tiles_y || !cells_x || !cells_y || !cells_z) return {};
  return GridShift{{*tiles_x, *tiles_y}, {*cells_x, *cells_y, *cells_z}};
}

std::vector<TilePair> pair_tiles(const MapSide& before, const MapSide& after,
                                 const std::optional<GridShift>& shift) {
  std::vector<TilePair> pairs;
  if (!shift) {
    for (std::uint32_t tile = 0; tile < after.tile_count(); ++tile) {
      pairs.emplace_back().after = tile;
    }
    for (std::uint32_t tile = 0; tile < before.tile_count(); ++tile) {
      pairs.emplace_back().before = tile;
    }
    return pairs;
  }
  for (auto& [key, pair] : tiles_by_place(before, after, *shift)) {
    compare(before, after, pair);
    pairs.push_back(pair);
  }
  return pairs;
}

std::vector<BlockDiff> diff_blocks(const MapSide& before, const MapSide& after,
                                   const std::vector<TilePair>& tiles) {
  std::map<std::string, BlockDiff> counts;
  for (const TilePair& pair : tiles) {
    const schema::Tile* old_tile = tile_at(before, pair.before);
    const schema::Tile* new_tile = tile_at(after, pair.after);
    count_blocks(old_tile == nullptr ? nullptr : old_tile->layers(),
                 new_tile == nullptr ? nullptr : new_tile->layers(), counts);
  }
  count_blocks(before.container().directory->sections(), after.container().directory->sections(),
               counts);
  std::vector<BlockDiff> blocks;
  for (auto& [name, count] : counts) blocks.push_back(count);
  return blocks;
}

}  // namespace sightline

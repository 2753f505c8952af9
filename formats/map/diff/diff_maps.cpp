#include "formats/map/diff/diff_maps.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "formats/map/diff/diff_facts.h"
#include "formats/map/diff/diff_places.h"
#include "formats/map/diff/diff_stretches.h"
#include "formats/map/diff/map_side.h"
#include "formats/reader/mapped_file.h"

namespace sightline {
namespace {

// Of one tile; nearest sites are looked for in the new map.
struct TileNds {
  std::vector<Nd> before;  // in the new map's frame
  std::vector<Nd> after;
};

DiffedMap describe(const MapSide& side) {
  DiffedMap map;
  map.map_id = side.card().map_id;
  map.version = side.card().version;
  map.release = side.card().release;
  map.root_digest = side.container().header.root_digest;
  map.nd_count = side.nd_count();
  map.world = side.card().world;
  map.site_count = side.site_count();
  map.tile_count = side.tile_count();
  map.file_size = side.container().header.file_size;
  return map;
}

Result<TileNds> read_nds(MapSide& before, MapSide& after, const TilePair& pair,
                         const GridShift& shift) {
  TileNds tile;
  if (pair.after) {
    SIGHTLINE_ASSIGN(tile.after, after.nds(*pair.after));
  }
  if (!pair.before) return tile;
  SIGHTLINE_ASSIGN(tile.before, before.nds(*pair.before));
  const Eigen::Vector3d shift_m =
      before.card().ndt.frame.origin_world_m - after.card().ndt.frame.origin_world_m;
  for (Nd& nd : tile.before) {
    nd.key = {nd.key.x + shift.cells.x, nd.key.y + shift.cells.y, nd.key.z + shift.cells.z};
    nd.mean_m += shift_m;
  }
  return tile;
}

// Farther than the tolerance, and outside the ellipsoid of one sigma of where it was.
bool has_moved(const Nd& before, const Nd& after, double tolerance_m) {
  const Eigen::Vector3d d_m = after.mean_m - before.mean_m;
  if (!(d_m.norm() > tolerance_m)) return false;
  const Eigen::Vector3d along_m = before.eigenvectors.transpose() * d_m;
  const Eigen::Vector3d lambda_m2 = before.eigenvalues_m2.cwiseMax(tolerance_m * tolerance_m);
  return along_m.cwiseAbs2().cwiseQuotient(lambda_m2).sum() > 1.0;
}

struct NdChanges {
  std::vector<NdDiff> changed;
  std::vector<Eigen::Vector3d> stayed_m;
};

// Both lists ascend by cell: one walk through both. Means stay in the new map's frame for now.
NdChanges diff_nds(const TileNds& tile, double tolerance_m) {
  NdChanges changes;
  auto before = tile.before.begin();
  auto after = tile.after.begin();
  while (before != tile.before.end() || after != tile.after.end()) {
    const bool is_gone =
        after == tile.after.end() || (before != tile.before.end() && before->key < after->key);
    const bool is_new =
        before == tile.before.end() || (after != tile.after.end() && after->key < before->key);
    if (is_gone) {
      changes.changed.push_back({NdChange::kRemoved, (before++)->mean_m, 0.0});
    } else if (is_new) {
      changes.changed.push_back({NdChange::kAdded, (after++)->mean_m, 0.0});
    } else {
      if (has_moved(*before, *after, tolerance_m)) {
        const double moved_m = (after->mean_m - before->mean_m).norm();
        changes.changed.push_back({NdChange::kMoved, after->mean_m, moved_m});
      } else {
        changes.stayed_m.push_back(after->mean_m);
      }
      ++before;
      ++after;
    }
  }
  return changes;
}

// Sites of an unchanged tile, which has a changed ND beside it.
Result<void> add_unchanged(MapSide& after, std::uint32_t tile, const CommonLimits& limits,
                           ComparedSites& compared) {
  SIGHTLINE_ASSIGN(const TileSites* sites, after.sites(tile));
  for (const SiteRow& row : sites->rows) {
    if (!compared.after.contains(row.site)) compared.after[row.site] = same_site(row, limits);
  }
  return {};
}

// The nearest site to an ND: of its own tile, else at most a tile away.
Result<const SiteRow*> site_near(MapSide& after, const Eigen::Vector3d& mean_m,
                                 const TileSites& own, const CommonLimits& limits,
                                 ComparedSites& compared) {
  constexpr double kAnywhere_m = std::numeric_limits<double>::infinity();
  const std::optional<NearPoint> of_own = own.grid.nearest(mean_m, kAnywhere_m);
  if (of_own) return &own.rows[of_own->index];
  const double tile_m = after.card().ndt.tile_m;
  SIGHTLINE_ASSIGN(const NearestSite nearest, after.nearest(mean_m, tile_m, MapSide::Level::kAny));
  if (nearest.row == nullptr) return nullptr;
  const TileKey key = tile_key(nearest.row->p_m, tile_m);
  const std::optional<std::uint32_t> tile = find_tile(after.container(), key.x, key.y);
  if (!tile) return nullptr;
  SIGHTLINE_TRY(add_unchanged(after, *tile, limits, compared));
  return nearest.row;
}

void count(NdChange change, NdCounts& counts) {
  ++(change == NdChange::kAdded     ? counts.added
     : change == NdChange::kRemoved ? counts.removed
                                    : counts.moved);
}

// Fills the NDs of `diff`, and returns which sites they are near to.
Result<NdsBySite> compare_nds(MapSide& before, MapSide& after, const std::vector<TilePair>& tiles,
                              const GridShift& shift, ComparedSites& compared, MapDiff& diff) {
  const CommonLimits limits = common_limits(before.card(), after.card());
  const TileSites no_sites;
  NdsBySite by_site;
  NdCounts all;
  for (const TilePair& pair : tiles) {
    if (pair.has_same_nds) continue;
    SIGHTLINE_ASSIGN(const TileNds tile, read_nds(before, after, pair, shift));
    const TileSites* own = &no_sites;
    if (pair.after) {
      SIGHTLINE_ASSIGN(own, after.sites(*pair.after));
    }
    NdChanges changes = diff_nds(tile, diff.options.tolerance_m);
    for (const Eigen::Vector3d& mean_m : changes.stayed_m) {
      SIGHTLINE_ASSIGN(const SiteRow* site, site_near(after, mean_m, *own, limits, compared));
      if (site != nullptr) ++by_site[site->site].stayed;
    }
    for (NdDiff& change : changes.changed) {
      SIGHTLINE_ASSIGN(const SiteRow* site,
                       site_near(after, change.mean_world_m, *own, limits, compared));
      count(change.change, all);
      if (site == nullptr) ++diff.nds_off_route;
      if (site != nullptr) count(change.change, by_site[site->site]);
      change.mean_world_m += after.card().ndt.frame.origin_world_m;
      diff.nds.push_back(change);
    }
  }
  diff.nds_added = all.added;
  diff.nds_removed = all.removed;
  diff.nds_moved = all.moved;
  return by_site;
}

void count_tiles(const std::vector<TilePair>& tiles, MapDiff& diff) {
  for (const TilePair& pair : tiles) {
    if (!pair.before) {
      ++diff.tiles_added;
    } else if (!pair.after) {
      ++diff.tiles_removed;
    } else if (!pair.has_same_digest) {
      ++diff.tiles_changed;
    }
  }
}

Result<MapDiff> diff_sides(MapSide& before, MapSide& after, const MapDiffOptions& options) {
  MapDiff diff;
  diff.options = options;
  diff.before = describe(before);
  diff.after = describe(after);
  diff.facts = diff_facts(before.card(), after.card());
  SIGHTLINE_ASSIGN(std::vector<FactDiff> columns, diff_columns(before, after));
  std::ranges::move(columns, std::back_inserter(diff.facts));
  const std::optional<GridShift> shift = grid_shift(before.card(), after.card());
  const std::vector<TilePair> tiles = pair_tiles(before, after, shift);
  diff.has_comparable_nds = shift.has_value();
  diff.blocks = diff_blocks(before, after, tiles);
  count_tiles(tiles, diff);
  SIGHTLINE_ASSIGN(ComparedSites compared, compare_sites(before, after, tiles));
  NdsBySite nds;
  if (shift) {
    SIGHTLINE_ASSIGN(nds, compare_nds(before, after, tiles, *shift, compared, diff));
  }
  count_sites(before.card(), after.card(), compared, diff);
  find_stretches(before.card(), after.card(), compared, nds, diff);
  diff.bytes_read = before.bytes_read() + after.bytes_read();
  return diff;
}

}  // namespace

Result<MapDiff> diff_maps(std::span<const std::byte> before, std::span<const std::byte> after,
                          const MapDiffOptions& options) {
  SIGHTLINE_ASSIGN(MapSide old_side, MapSide::open(before));
  SIGHTLINE_ASSIGN(MapSide new_side, MapSide::open(after));
  return diff_sides(old_side, new_side, options);
}

Result<MapDiff> diff_maps(const std::filesystem::path& before, const std::filesystem::path& after,
                          const MapDiffOptions& options) {
  SIGHTLINE_ASSIGN(const MappedFile old_file,
                   MappedFile::open(before.string(), MappedFile::Use::kHereAndThere));
  SIGHTLINE_ASSIGN(const MappedFile new_file,
                   MappedFile::open(after.string(), MappedFile::Use::kHereAndThere));
  Result<MapSide> old_side = MapSide::open(old_file.bytes());
  if (!old_side) return in_file(old_side.error(), before.string());
  Result<MapSide> new_side = MapSide::open(new_file.bytes());
  if (!new_side) return in_file(new_side.error(), after.string());
  return diff_sides(*old_side, *new_side, options);
}

}  // namespace sightline

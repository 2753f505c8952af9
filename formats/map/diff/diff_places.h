#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "formats/map/diff/map_diff.h"
#include "formats/map/diff/map_side.h"

// What two maps contain at the same places: tiles and blocks, by digest alone, then sites.

namespace sightline {

// How the new map's grid lies in the old one's: a tile and a cell of the old map, plus these, are
// the same place in the new one.
struct GridShift {
  TileKey tiles;
  CellKey cells;
};
// None where tiles or cells of one map do not coincide with those of the other.
std::optional<GridShift> grid_shift(const CompiledMap& before, const CompiledMap& after);

// The same place in both directories.
struct TilePair {
  std::optional<std::uint32_t> before;
  std::optional<std::uint32_t> after;
  bool has_same_digest = false;  // of all that a vehicle acts on
  bool has_same_nds = false;
  bool has_same_sites = false;
};
// All tiles of both maps, ascending by the new map's keys. Without a shift no tile has a partner.
std::vector<TilePair> pair_tiles(const MapSide& before, const MapSide& after,
                                 const std::optional<GridShift>& shift);

// Layers and sections, by name, ascending.
std::vector<BlockDiff> diff_blocks(const MapSide& before, const MapSide& after,
                                   const std::vector<TilePair>& tiles);

// A limit that both maps have, as the index of it in each.
using CommonLimits = std::vector<std::pair<std::size_t, std::size_t>>;
CommonLimits common_limits(const CompiledMap& before, const CompiledMap& after);

// A site of the new map beside the old map's answer there; answers are of the common limits.
struct ComparedSite {
  const SiteRow* row = nullptr;
  bool is_known_before = false;
  std::vector<AnswerDiff> answers;  // where it is known
  double distance_m = 0.0;          // to the old site
  double longest_points_before = 0.0;
  double longest_points_after = 0.0;
};
// A site that the old map has as well.
ComparedSite same_site(const SiteRow& row, const CommonLimits& limits);

// By site: those of every new tile where NDs or answers may differ; of the old map those of such
// tiles where the new map has no answer.
struct ComparedSites {
  std::map<std::uint32_t, ComparedSite> after;
  std::map<std::uint32_t, const SiteRow*> only_before;
};
Result<ComparedSites> compare_sites(MapSide& before, MapSide& after,
                                    std::span<const TilePair> tiles);

// Fills sites, limits and their counts of `diff`.
void count_sites(const CompiledMap& before, const CompiledMap& after, const ComparedSites& compared,
                 MapDiff& diff);

}  // namespace sightline

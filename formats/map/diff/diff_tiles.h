#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/map/diff/map_diff.h"
#include "formats/map/diff/map_side.h"

// Which tiles and blocks of two maps differ, by digest alone.

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

}  // namespace sightline

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/map/compiled_map.h"
#include "formats/map/container/packed_block.h"
#include "formats/reader/map_layout.h"

// Layers of a tile as they lie in the file (schemas/map_format.md), and back.

namespace sightline {

AnswerShape answer_shape(const CompiledMap& map);

// What belongs to one tile: indices of NDs (by their cell) and of sites (by their p), ascending.
struct TileRows {
  TileKey key;
  std::vector<std::uint32_t> nds;
  std::vector<std::uint32_t> sites;
};

// Every tile that holds anything, ascending by key.
std::vector<TileRows> tiles_of(const CompiledMap& map);

// Means are rounded to kMeanUnit_m (at most 30 nm off, and never out of the cell), covariances to
// float (relative 6e-8). Encoding what was decoded gives the same bytes.
std::vector<std::byte> encode_ndt_layer(const NdtMap& ndt, std::span<const std::uint32_t> rows);
// Appends to `ndt`, whose frame, cell and tile size are set. Errors: bad-layer, bad-order (a cell
// of another tile).
Result<void> decode_ndt_layer(std::span<const std::byte> raw, std::uint64_t row_count, TileKey key,
                              NdtMap& ndt);

// Slots for what range layers tell of so many sites, in a map that knows its looks and limits.
void make_room_for_sites(std::size_t sites, CompiledMap& map);

// Exact.
std::vector<std::byte> encode_range_layer(const CompiledMap& map,
                                          std::span<const std::uint32_t> rows);
// Fills the slots of the layer's sites in a map whose vectors have their sizes already; `is_filled`
// marks which slots are taken. Errors: bad-layer, bad-order.
Result<void> decode_range_layer(std::span<const std::byte> raw, std::uint64_t row_count,
                                TileKey key, CompiledMap& map, std::vector<bool>& is_filled);

// As a map of this size stores them: Zstandard and plain, or the codecs "nds" and "columns". NDs of
// a small map that are not all small are stored as in a full one.
StoredBlock store_ndt_layer(std::span<const std::byte> raw, std::uint64_t row_count, double cell_m,
                            MapSize size);
StoredBlock store_range_layer(std::span<const std::byte> raw, std::uint64_t row_count,
                              const AnswerShape& shape);

}  // namespace sightline

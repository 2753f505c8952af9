#pragma once

#include <cstddef>
#include <span>

#include "formats/surroundings/ndt_map.h"
#include "formats/tables/stored_table.h"

namespace sightline {

// A row is an ND, without what follows from its covariance.
template <>
struct RowsOf<NdtMap> {
  static std::size_t size(const NdtMap& /*head*/) {
    return 4 * sizeof(std::int32_t) + 9 * sizeof(double);
  }
  static std::size_t count(const NdtMap& map) { return map.nds.size(); }
  static NdtMap head_of(const NdtMap& map);
  // Without counts.
  static NdtMap part_of(const NdtMap& head, std::size_t first, std::size_t count);
  static void resize(NdtMap& head, std::size_t count) { head.nds.resize(count); }
  static void encode_head(const NdtMap& map, ByteWriter& writer);
  static void decode_head(ByteReader& reader, NdtMap& map);
  static void encode(const NdtMap& map, std::size_t first, std::size_t count, ByteWriter& writer);
  static void decode(ByteReader& reader, NdtMap& map, std::size_t first, std::size_t count);
  static TileKey tile(const NdtMap& head, std::span<const std::byte> row);
  static double reach_m(std::span<const std::byte> /*row*/) { return 0.0; }
};

// The NDs of a map, tile by tile.
using TiledNds = StoredTable<NdtMap>;

}  // namespace sightline

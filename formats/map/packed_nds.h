#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/base/files/stored_bytes.h"
#include "formats/map/container/map_size.h"
#include "formats/map/container/packed_block.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/tables/head_and_bytes.h"

namespace sightline {

// The NDs of one tile as the map file carries them: the block of its layer "ndt".
struct PackedNdTile {
  TileKey key;
  std::uint64_t nd_count = 0;
  BlockCodec codec = BlockCodec::kNone;
  std::uint64_t raw_size = 0;
  std::uint64_t stored_checksum = 0;
  Digest raw_digest{};
  std::uint64_t offset = 0;  // among the blocks
  std::uint64_t stored_size = 0;
};
SIGHTLINE_FIELDS(PackedNdTile, key, nd_count, codec, raw_size, stored_checksum, raw_digest, offset,
                 stored_size)

// The NDs of a map, ready for its file: who writes a map of a long street holds no ND of it but
// those of one tile.
struct PackedNds {
  MapFrame frame;
  double cell_m = 2.0;
  double tile_m = 64.0;
  std::uint64_t nd_count = 0;
  std::uint64_t sparse_cell_count = 0;  // as in NdtMap
  std::uint64_t degenerate_cell_count = 0;
  std::uint64_t point_count = 0;
  std::vector<PackedNdTile> tiles;  // that hold NDs, ascending by key
  StoredBytes blocks;               // one after another
};
SIGHTLINE_SOME_FIELDS(PackedNds, frame, cell_m, tile_m, nd_count, sparse_cell_count,
                      degenerate_cell_count, point_count, tiles)
template <>
inline constexpr auto kBytesOf<PackedNds> = &PackedNds::blocks;
SIGHTLINE_ARTIFACT(PackedNds, "packed-nds", 2)

// Rounded and stored as layers.h says. Errors: cannot-read, disk-full, cannot-write.
Result<PackedNds> pack_nds(const TiledNds& nds, MapSize size = MapSize::kFull);

// A layer as container_writer.h takes it; what is stored lies in `bytes`. Error: cannot-read.
Result<PackedBlock> read_layer(const PackedNds& nds, const PackedNdTile& tile,
                               std::vector<std::byte>& bytes);

// All but the NDs themselves.
NdtMap without_nds(const PackedNds& nds);
// Rounded. Errors: cannot-read; those of checked_bytes() and decode_ndt_layer().
Result<NdtMap> unpacked(const PackedNds& nds);

// Reads every tile.
Result<void> validate(const PackedNds& nds);
Table dump(const PackedNds& nds);  // one row a tile

}  // namespace sightline

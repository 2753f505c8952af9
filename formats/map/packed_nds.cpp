#include "formats/map/packed_nds.h"

#include <numeric>
#include <string>

#include "formats/map/layers.h"
#include "formats/reader/map_layout.h"

namespace sightline {
namespace {

constexpr std::size_t kMostInMemory = std::size_t{2} << 20;  // of a kilometre or two

Error invalid_tile(const char* message, const TileKey& tile) {
  return {ErrorCode::kInvalidArtifact, message, "",
          "tile " + std::to_string(tile.x) + ", " + std::to_string(tile.y)};
}

// Blocks follow each other and fill what there is.
Result<void> validate_blocks(const PackedNds& nds) {
  std::uint64_t end = 0;
  for (const PackedNdTile& tile : nds.tiles) {
    if (tile.offset != end || tile.stored_size > nds.blocks.size() - end) {
      return invalid_tile("a block is outside the blocks", tile.key);
    }
    if (tile.nd_count > kMostRows) return invalid_tile("a tile holds too many NDs", tile.key);
    end += tile.stored_size;
  }
  if (end != nds.blocks.size()) return invalid_tile("bytes follow the last block", {});
  return {};
}

Result<void> append_unpacked(const PackedNds& nds, const PackedNdTile& tile, NdtMap& map) {
  std::vector<std::byte> bytes;
  SIGHTLINE_ASSIGN(const PackedBlock block, read_layer(nds, tile, bytes));
  SIGHTLINE_ASSIGN(const RawBytes raw, checked_bytes(block));
  if (raw.bytes().size() != NdtLayout(tile.nd_count).size) {
    return invalid_tile("the size of a layer does not match its NDs", tile.key);
  }
  return decode_ndt_layer(raw.bytes(), tile.nd_count, tile.key, map);
}

}  // namespace

Result<PackedNds> pack_nds(const TiledNds& nds, MapSize size) {
  const NdtMap& head = nds.head();
  PackedNds packed{head.frame,
                   head.cell_m,
                   head.tile_m,
                   nds.row_count(),
                   head.sparse_cell_count,
                   head.degenerate_cell_count,
                   head.point_count,
                   {},
                   {}};
  GrowingBytes blocks(kMostInMemory);
  for (const RowTile& tile : nds.tiles()) {
    SIGHTLINE_ASSIGN(const NdtMap of_tile, nds.tile(tile));
    std::vector<std::uint32_t> rows(of_tile.nds.size());
    std::iota(rows.begin(), rows.end(), 0U);
    const std::vector<std::byte> raw = encode_ndt_layer(of_tile, rows);
    const StoredBlock stored = store_ndt_layer(raw, rows.size(), head.cell_m, size);
    packed.tiles.push_back({tile.key, rows.size(), stored.codec, raw.size(),
                            block_checksum(stored.bytes), sha256(raw), blocks.size(),
                            stored.bytes.size()});
    SIGHTLINE_TRY(blocks.append(stored.bytes));
  }
  packed.blocks = blocks.take();
  return packed;
}

Result<PackedBlock> read_layer(const PackedNds& nds, const PackedNdTile& tile,
                               std::vector<std::byte>& bytes) {
  SIGHTLINE_ASSIGN(bytes, nds.blocks.read(tile.offset, tile.stored_size));
  return PackedBlock{
      std::string(kNdtLayer), kNdtLayerVersion, true, tile.codec, tile.nd_count, tile.raw_size,
      tile.stored_checksum,   tile.raw_digest,  bytes};
}

NdtMap without_nds(const PackedNds& nds) {
  return {
      nds.frame,      nds.cell_m, nds.tile_m, {}, nds.sparse_cell_count, nds.degenerate_cell_count,
      nds.point_count};
}

Result<NdtMap> unpacked(const PackedNds& nds) {
  NdtMap map = without_nds(nds);
  for (const PackedNdTile& tile : nds.tiles) SIGHTLINE_TRY(append_unpacked(nds, tile, map));
  return map;
}

Result<void> validate(const PackedNds& nds) {
  NdtMap of_tile = without_nds(nds);
  SIGHTLINE_TRY(validate(of_tile));
  SIGHTLINE_TRY(validate_blocks(nds));
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < nds.tiles.size(); ++i) {
    const PackedNdTile& tile = nds.tiles[i];
    if (tile.nd_count == 0) return invalid_tile("a tile without NDs", tile.key);
    if (i > 0 && !(nds.tiles[i - 1].key < tile.key)) {
      return invalid_tile("tiles must ascend", tile.key);
    }
    of_tile.nds.clear();
    SIGHTLINE_TRY(append_unpacked(nds, tile, of_tile));
    SIGHTLINE_TRY(validate(of_tile));
    count += tile.nd_count;
  }
  if (count != nds.nd_count) return invalid_tile("the tiles do not contain all NDs", {});
  return {};
}

Table dump(const PackedNds& nds) {
  Table table{"packed-nds", {}, {}, {}};
  append_facts(nds.frame, table);
  table.facts.emplace_back("cell_m", nds.cell_m);
  table.facts.emplace_back("tile_m", nds.tile_m);
  table.facts.emplace_back("nd_count", static_cast<std::int64_t>(nds.nd_count));
  table.columns = {"tile_x", "tile_y", "nds", "raw_bytes", "raw_sha256"};
  for (const PackedNdTile& tile : nds.tiles) {
    table.rows.push_back({std::int64_t{tile.key.x}, std::int64_t{tile.key.y},
                          static_cast<std::int64_t>(tile.nd_count),
                          static_cast<std::int64_t>(tile.raw_size), to_hex(tile.raw_digest)});
  }
  return table;
}

}  // namespace sightline

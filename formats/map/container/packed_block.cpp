#include "formats/map/container/packed_block.h"

#include <zstd.h>

#include <algorithm>
#include <memory>
#include <string>

#include "formats/base/bytes.h"
#include "formats/base/zstd_memory.h"
#include "formats/map/container/packed_columns.h"
#include "formats/map/container/small_nds.h"
#include "formats/reader/map_layout.h"
#include "map_generated.h"

namespace sightline {
namespace {

Error wrong(ErrorCode code, const PackedBlock& block, const char* what) {
  return {code, "block " + block.name + " does not match its " + what};
}

template <class... T>
void add_numbers(DigestBuilder& builder, T... values) {
  ByteWriter writer;
  (writer.put(values), ...);
  builder.add(writer.bytes());
}

void add_blocks(DigestBuilder& builder, const std::vector<BlockName>& blocks) {
  for (const BlockName& block : blocks) {
    builder.add(block.name);
    add_numbers(builder, block.version);
    add_numbers(builder, block.row_count);
    builder.add(block.raw_digest);
  }
}

}  // namespace

PackedBlock packed_block(const MapContainer& container, const schema::Block& block) {
  PackedBlock packed;
  packed.name = block.name()->str();
  packed.version = block.version();
  packed.is_required = block.is_required();
  packed.codec = static_cast<BlockCodec>(block.codec());
  packed.row_count = block.row_count();
  packed.raw_size = block.raw_size();
  packed.stored_checksum = block.stored_checksum();
  packed.raw_digest = to_digest(*block.raw_digest());
  packed.stored = located_bytes(container, block);
  return packed;
}

PackedTile packed_tile(const MapContainer& container, const schema::Tile& tile) {
  PackedTile packed{{tile.x(), tile.y()}, to_digest(*tile.digest()), {}};
  for (const schema::Block* layer : *tile.layers()) {
    packed.layers.push_back(packed_block(container, *layer));
  }
  return packed;
}

Digest required_digest(const PackedTile& tile) {
  std::vector<BlockName> required;
  for (const PackedBlock& layer : tile.layers) {
    if (!layer.is_required) continue;
    required.push_back({layer.name, layer.version, layer.row_count, layer.raw_digest});
  }
  return tile_digest(tile.key, required);
}

Digest to_digest(const schema::Digest& digest) {
  Digest bytes{};
  std::copy(digest.bytes()->begin(), digest.bytes()->end(), bytes.begin());
  return bytes;
}

Error wrong_digest(const std::string& what, const std::string& place) {
  return {ErrorCode::kDigestMismatch, what + " does not match its digest", "", place};
}

Result<void> check_zeros(std::span<const std::byte> file, std::uint64_t begin, std::uint64_t end) {
  for (std::uint64_t i = begin; i < end; ++i) {
    if (file[i] == std::byte{0}) continue;
    return Error{ErrorCode::kOutOfBounds, "bytes between two blocks must be zero", "",
                 "byte " + std::to_string(i)};
  }
  return {};
}

Result<RawBytes> checked_bytes(const PackedBlock& block) {
  if (block_checksum(block.stored) != block.stored_checksum) {
    return wrong(ErrorCode::kChecksumMismatch, block, "checksum");
  }
  RawBytes raw(block.stored);
  if (block.codec != BlockCodec::kNone && block.codec <= BlockCodec::kColumns) {
    SIGHTLINE_ASSIGN(std::vector<std::byte> unpacked,
                     unpack(block.codec, block.stored, block.row_count, block.raw_size));
    raw = RawBytes(std::move(unpacked));
  } else if (block.codec != BlockCodec::kNone || block.raw_size != block.stored.size()) {
    return Error{ErrorCode::kBadLayer, "the codec is unknown or the sizes differ"};
  }
  if (sha256(raw.bytes()) != block.raw_digest) {
    return wrong(ErrorCode::kDigestMismatch, block, "digest");
  }
  return raw;
}

StoredBlock pack(std::span<const std::byte> raw) {
  StoredBlock block;
  // Memory that is not written to takes none: of a large block little is.
  const std::size_t room = ZSTD_compressBound(raw.size());
  const auto packed = std::make_unique_for_overwrite<std::byte[]>(room);
  const std::size_t size =
      with_memory(ZSTD_compress(packed.get(), room, raw.data(), raw.size(), kPackLevel));
  if (ZSTD_isError(size) == 0 && is_worth_packing(raw.size(), size)) {
    block.codec = BlockCodec::kZstd;
    block.bytes.assign(packed.get(), packed.get() + size);
  } else {
    block.bytes.assign(raw.begin(), raw.end());
  }
  return block;
}

Result<std::vector<std::byte>> unpack(BlockCodec codec, std::span<const std::byte> stored,
                                      std::uint64_t row_count, std::uint64_t raw_size) {
  switch (codec) {
    case BlockCodec::kZstd:
      return unpack_zstd(stored, raw_size);
    case BlockCodec::kNds:
      return unpack_small_nds(stored, row_count, raw_size);
    case BlockCodec::kColumns:
      return unpack_columns(stored, row_count, raw_size);
    case BlockCodec::kNone:
      break;
  }
  return unreadable_block();
}

Digest tile_digest(TileKey key, const std::vector<BlockName>& required_layers) {
  DigestBuilder builder;
  builder.add("sightline tile");
  add_numbers(builder, key.x, key.y);
  add_blocks(builder, required_layers);
  return builder.finish();
}

Digest root_digest(const Digest& manifest, std::uint64_t incompatible_features,
                   const std::vector<Digest>& tiles,
                   const std::vector<BlockName>& required_sections) {
  DigestBuilder builder;
  builder.add("sightline map");
  builder.add(manifest);
  add_numbers(builder, incompatible_features);
  add_numbers(builder, std::uint64_t{tiles.size()});
  for (const Digest& tile : tiles) builder.add(tile);
  add_blocks(builder, required_sections);
  return builder.finish();
}

}  // namespace sightline

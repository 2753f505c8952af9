#include "formats/map/map_decoder.h"

#include <algorithm>

#include "formats/map/container/contents_layer.h"
#include "formats/map/container/packed_block.h"
#include "formats/map/layers.h"
#include "formats/map/manifest.h"
#include "formats/map/site_columns.h"
#include "formats/reader/map_checks.h"
#include "map_generated.h"

namespace sightline {
namespace {

std::string byte_place(std::uint64_t offset) { return "byte " + std::to_string(offset); }

Error at(Error error, const std::string& place) {
  error.place = error.place.empty() ? place : place + ", " + error.place;
  return error;
}

Error not_derived(const char* what) {
  return {ErrorCode::kBadLayer, std::string("it differs from ") + what};
}

std::uint64_t offset_of(const MapContainer& container, const PackedBlock& block) {
  return static_cast<std::uint64_t>(block.stored.data() - container.file.data());
}

}  // namespace

MapDecoder::MapDecoder(const MapContainer& container, KeepNds keep_nds)
    : container_(container),
      keep_nds_(keep_nds),
      checked_to_(container.header.manifest_offset + container.header.manifest_size) {}

// How many rows there are to come, before anything is allocated for them.
Result<void> MapDecoder::check_counts() const {
  std::uint64_t nds = 0;
  std::uint64_t sites = 0;
  for (const schema::Tile* tile : *container_.directory->tiles()) {
    for (const schema::Block* block : *tile->layers()) {
      if (block->name()->string_view() == kNdtLayer) nds += block->row_count();
      if (block->name()->string_view() == kRangeLayer) sites += block->row_count();
    }
  }
  const schema::Manifest& manifest = *container_.manifest;
  if (nds == manifest.nd_count() && sites == manifest.site_count()) return {};
  return Error{ErrorCode::kBadManifest,
               concat("found ", nds, " NDs and ", sites, " sites, expected ", manifest.nd_count(),
                      " and ", manifest.site_count()),
               "", "directory"};
}

// Also where nothing is done with the bytes: what is optional and unknown has a digest too.
Result<RawBytes> MapDecoder::raw_bytes(const PackedBlock& block) {
  const std::uint64_t offset = offset_of(container_, block);
  SIGHTLINE_TRY(check_zeros(container_.file, checked_to_, offset));
  checked_to_ = offset + block.stored.size();
  MapSummary::Blocks& sum = blocks_[block.name];
  sum.is_required = block.is_required;
  sum.block_count += 1;
  sum.row_count += block.row_count;
  sum.raw_size += block.raw_size;
  sum.stored_size += block.stored.size();
  if (block.is_required) required_kinds_.insert({block.name, block.version});
  if (block.codec >
      BlockCodec::kColumns) {  // optional and unknown: its checksum alone can be checked
    if (block_checksum(block.stored) == block.stored_checksum) return RawBytes(block.stored);
    return Error{ErrorCode::kChecksumMismatch, "the block does not match its checksum", "",
                 byte_place(offset)};
  }
  Result<RawBytes> raw = checked_bytes(block);
  if (!raw) return at(raw.error(), byte_place(offset));
  return raw;
}

// NDs that are not kept are checked a layer at a time.
Result<void> MapDecoder::decode_layer(const PackedBlock& block, std::span<const std::byte> raw,
                                      TileKey key) {
  if (block.name == kNdtLayer && keep_nds_ == KeepNds::kNo) {
    NdtMap of_tile = map_.ndt;  // which stays without any ND
    SIGHTLINE_TRY(decode_ndt_layer(raw, block.row_count, key, of_tile));
    return validate(of_tile);
  }
  SIGHTLINE_TRY(decoder_->decode_layer(block, raw, key));
  if (block.name == kRangeLayer) look_up_->add(raw, block.row_count);
  return {};
}

Result<void> MapDecoder::visit_layer(const PackedBlock& block, TileKey key) {
  SIGHTLINE_ASSIGN(const RawBytes raw, raw_bytes(block));
  const Result<void> decoded = decode_layer(block, raw.bytes(), key);
  if (decoded) return {};
  return at(decoded.error(), byte_place(offset_of(container_, block)));
}

// The second list, for a file that lost its directory, must agree with the directory.
Result<void> MapDecoder::check_contents(const PackedTile& tile) const {
  for (const PackedBlock& layer : tile.layers) {
    if (layer.name != kContentsLayer || layer.version != kContentsLayerVersion) continue;
    const std::vector<std::byte> expected =
        encode_contents(contents_of(tile.key, tile.digest, tile.layers));
    if (!std::ranges::equal(layer.stored, expected)) {
      return at(not_derived("the directory"),
                "layer " + layer.name + ", " + byte_place(offset_of(container_, layer)));
    }
  }
  return {};
}

Result<void> MapDecoder::visit_tile(const schema::Tile& entry) {
  const PackedTile tile = packed_tile(container_, entry);
  for (const PackedBlock& block : tile.layers) {
    const Result<void> layer = visit_layer(block, tile.key);
    if (!layer) return at(layer.error(), "layer " + block.name);
  }
  if (required_digest(tile) != tile.digest) {
    return wrong_digest("the tile", byte_place(container_.header.directory_offset));
  }
  return check_contents(tile);
}

Result<void> MapDecoder::check_look_up() const {
  const schema::Block* section = find_section(container_, kLookUpSection);
  const FileHeader& header = container_.header;
  if (section == nullptr || section->version() != kLookUpSectionVersion || !has_look_up(header)) {
    return Error{
        ErrorCode::kBadLayer,
        "the section look-up, which every map needs, is missing or not listed in the header", "",
        "byte 16"};
  }
  const PackedBlock block = packed_block(container_, *section);
  const std::string place =
      "section " + block.name + ", " + byte_place(offset_of(container_, block));
  if (section->offset() + section->stored_size() != header.directory_offset) {
    return Error{ErrorCode::kBadLayer, "it does not end where the directory begins", "", place};
  }
  const std::vector<std::byte> expected = look_up_->finish(header, required_kinds_);
  if (std::ranges::equal(block.stored, expected)) return {};
  return at(not_derived("the range layers"), place);
}

Result<void> MapDecoder::visit_column(const PackedBlock& block, std::span<const std::byte> raw) {
  for (SiteColumn& column : map_.columns) {
    if (block.name != column_section(column.name)) continue;
    const std::string place = byte_place(offset_of(container_, block));
    if (block.codec != BlockCodec::kNone ||
        block.version != column_version(!column.steps.empty())) {
      return Error{ErrorCode::kBadLayer, "a column is compressed or of another version", "", place};
    }
    const Result<void> checked = check_column(container_, column.name, raw);
    if (!checked) return at(checked.error(), place);
    return decode_column(raw, map_.sites.sites.size(), column);
  }
  return {};  // of a later program
}

Result<void> MapDecoder::visit_section(const PackedBlock& block) {
  SIGHTLINE_ASSIGN(const RawBytes raw, raw_bytes(block));
  if (block.name.starts_with(kColumnSection) && block.version <= kSteppedColumnVersion) {
    return visit_column(block, raw.bytes());
  }
  const Result<void> decoded = decoder_->decode_section(block, raw.bytes());
  if (decoded) return {};
  return at(decoded.error(), byte_place(offset_of(container_, block)));
}

Result<void> MapDecoder::visit_all() {
  std::vector<Digest> tiles;
  for (const schema::Tile* tile : *container_.directory->tiles()) {
    const Result<void> visited = visit_tile(*tile);
    if (!visited) return at(visited.error(), tile_place(tile->x(), tile->y()));
    tiles.push_back(to_digest(*tile->digest()));
  }
  for (const schema::Block* section : *container_.directory->sections()) {
    const PackedBlock block = packed_block(container_, *section);
    const Result<void> visited = visit_section(block);
    if (!visited) return at(visited.error(), "section " + block.name);
  }
  SIGHTLINE_TRY(check_look_up());
  SIGHTLINE_TRY(decoder_->check_factors());
  return check_end(tiles);
}

Result<void> MapDecoder::check_end(const std::vector<Digest>& tiles) const {
  const FileHeader& header = container_.header;
  SIGHTLINE_TRY(check_zeros(container_.file, checked_to_, header.directory_offset));
  SIGHTLINE_TRY(check_zeros(container_.file, header.directory_offset + header.directory_size,
                            container_.file.size() - kTrailerSize));
  const std::vector<BlockName> required;  // format 1 has no required sections
  const Digest manifest =
      sha256(container_.file.subspan(header.manifest_offset, header.manifest_size));
  if (root_digest(manifest, header.incompatible_features, tiles, required) != header.root_digest) {
    return wrong_digest("the map", "byte 88");
  }
  return {};
}

void MapDecoder::make_room() {
  decoder_.emplace(container_.manifest->site_count(), map_);
  decoder_->expect_factors(container_);
  look_up_.emplace(answer_shape(map_), map_.reach_m);
}

Result<CompiledMap> MapDecoder::run() {
  SIGHTLINE_TRY(check_zeros(container_.file, kHeaderSize, container_.header.manifest_offset));
  SIGHTLINE_TRY(check_counts());
  SIGHTLINE_TRY(decode_manifest(*container_.manifest, map_));
  make_room();
  SIGHTLINE_TRY(visit_all());
  decoder_->take_factors();
  SIGHTLINE_TRY(validate(map_));
  const std::uint64_t found = simulated_site_count(map_.ranges);
  const std::uint64_t expected = container_.manifest->simulated_site_count();
  if (found != expected) {
    return Error{ErrorCode::kBadManifest,
                 concat("found ", found, " simulated sites, expected ", expected), "", "manifest"};
  }
  return std::move(map_);
}

std::vector<MapSummary::Blocks> MapDecoder::blocks() const {
  std::vector<MapSummary::Blocks> blocks;
  for (const auto& [name, sum] : blocks_) {
    blocks.push_back(sum);
    blocks.back().name = name;
  }
  return blocks;
}

}  // namespace sightline

#include "formats/map/map_reader.h"

#include <algorithm>
#include <map>
#include <utility>

#include "formats/map/block_codec.h"
#include "formats/map/factor_layer.h"
#include "formats/map/layers.h"
#include "formats/map/manifest.h"
#include "formats/map/map_digests.h"
#include "formats/reader/map_checks.h"
#include "formats/reader/map_container.h"
#include "formats/reader/mapped_file.h"
#include "map_generated.h"

namespace sightline {
namespace {

Error at(Error error, const std::string& place) {
  error.place = error.place.empty() ? place : place + ", " + error.place;
  return error;
}

Digest from_schema(const schema::Digest& digest) {
  Digest bytes{};
  std::copy(digest.bytes()->begin(), digest.bytes()->end(), bytes.begin());
  return bytes;
}

Error wrong_digest(const std::string& what, const std::string& place) {
  return {ErrorCode::kDigestMismatch, what + " does not match its digest", "", place};
}

// Goes through a file block by block, in order, and decodes on the way.
class MapDecoder {
 public:
  explicit MapDecoder(const MapContainer& container)
      : container_(container),
        checked_to_(container.header.manifest_offset + container.header.manifest_size) {}

  Result<CompiledMap> run();
  MapSummary summary() const;

 private:
  Result<void> check_padding(std::uint64_t begin, std::uint64_t end) const;
  Result<void> check_counts();
  Result<std::vector<std::byte>> raw_bytes(const schema::Block& block);
  Result<void> visit_tile(const schema::Tile& tile);
  Result<void> visit_layer(const schema::Block& block, TileKey key);
  Result<void> visit_section(const schema::Block& block);
  Result<void> visit_all();
  void expect_factors();
  Result<void> check_factors() const;

  const MapContainer& container_;
  std::uint64_t checked_to_;  // every byte before it has been looked at
  CompiledMap map_;
  std::vector<bool> is_filled_;
  std::vector<bool> has_factors_;  // by site; empty where the map names no factors
  std::map<std::string, MapSummary::Blocks> blocks_;
};

Result<void> MapDecoder::check_padding(std::uint64_t begin, std::uint64_t end) const {
  for (std::uint64_t i = begin; i < end; ++i) {
    if (container_.file[i] == std::byte{0}) continue;
    return Error{ErrorCode::kOutOfBounds, "bytes between two blocks must be zero", "",
                 "byte " + std::to_string(i)};
  }
  return {};
}

// How many rows there are to come, before anything is allocated for them.
Result<void> MapDecoder::check_counts() {
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
               "found " + std::to_string(nds) + " NDs and " + std::to_string(sites) +
                   " sites, expected " + std::to_string(manifest.nd_count()) + " and " +
                   std::to_string(manifest.site_count()),
               "", "directory"};
}

Result<std::vector<std::byte>> MapDecoder::raw_bytes(const schema::Block& block) {
  const Result<void> padding = check_padding(checked_to_, block.offset());
  if (!padding) return padding.error();
  checked_to_ = block.offset() + block.stored_size();
  const Result<std::span<const std::byte>> stored = stored_bytes(container_, block);
  if (!stored) return stored.error();
  MapSummary::Blocks& sum = blocks_[block.name()->str()];
  sum.is_required = block.is_required();
  sum.block_count += 1;
  sum.row_count += block.row_count();
  sum.raw_size += block.raw_size();
  sum.stored_size += block.stored_size();
  if (block.codec() > schema::Codec::MAX) return std::vector<std::byte>();  // optional and unknown
  std::vector<std::byte> raw;
  if (block.codec() == schema::Codec::Zstd) {
    Result<std::vector<std::byte>> unpacked = unpack_zstd(*stored, block.raw_size());
    if (!unpacked) return unpacked.error();
    raw = std::move(*unpacked);
  } else {
    raw.assign(stored->begin(), stored->end());
  }
  if (sha256(raw) != from_schema(*block.raw_digest())) {
    return wrong_digest("block " + block.name()->str(), "byte " + std::to_string(block.offset()));
  }
  return raw;
}

Result<void> MapDecoder::visit_layer(const schema::Block& block, TileKey key) {
  const Result<std::vector<std::byte>> raw = raw_bytes(block);
  if (!raw) return raw.error();
  const std::string_view name = block.name()->string_view();
  if (name == kNdtLayer) return decode_ndt_layer(*raw, block.row_count(), key, map_.ndt);
  if (name == kRangeLayer) {
    return decode_range_layer(*raw, block.row_count(), key, map_, is_filled_);
  }
  if (name == kFactorLayer && block.version() == kFactorLayerVersion && !has_factors_.empty()) {
    return decode_factor_layer(*raw, block.row_count(), map_.factors, has_factors_);
  }
  return {};
}

Result<void> MapDecoder::visit_tile(const schema::Tile& tile) {
  const TileKey key{tile.x(), tile.y()};
  std::vector<BlockName> required;
  for (const schema::Block* block : *tile.layers()) {
    const Result<void> layer = visit_layer(*block, key);
    if (!layer) return at(layer.error(), "layer " + block->name()->str());
    if (!block->is_required()) continue;
    required.push_back({block->name()->str(), block->version(), block->row_count(),
                        from_schema(*block->raw_digest())});
  }
  if (tile_digest(key, required) != from_schema(*tile.digest()))
    return wrong_digest("the tile", "");
  return {};
}

Result<void> MapDecoder::visit_section(const schema::Block& block) {
  Result<std::vector<std::byte>> raw = raw_bytes(block);
  if (!raw) return raw.error();
  if (block.name()->string_view() == kFactorNames && !has_factors_.empty()) {
    return decode_factor_names(*raw, map_.factors);
  }
  if (block.name()->string_view() != kModelSection) return {};
  if (sha256(*raw) != map_.model.digest) return wrong_digest("the error model", "");
  map_.model.bytes = std::move(*raw);
  return {};
}

Result<void> MapDecoder::visit_all() {
  std::vector<Digest> tiles;
  for (const schema::Tile* tile : *container_.directory->tiles()) {
    const Result<void> visited = visit_tile(*tile);
    if (!visited) return at(visited.error(), tile_place(tile->x(), tile->y()));
    tiles.push_back(from_schema(*tile->digest()));
  }
  std::vector<BlockName> required;  // format 1.0 has no required sections
  for (const schema::Block* section : *container_.directory->sections()) {
    const Result<void> visited = visit_section(*section);
    if (!visited) return at(visited.error(), "section " + section->name()->str());
  }
  const Result<void> factors = check_factors();
  if (!factors) return factors;
  const FileHeader& header = container_.header;
  const Result<void> before = check_padding(checked_to_, header.directory_offset);
  if (!before) return before;
  const Result<void> after = check_padding(header.directory_offset + header.directory_size,
                                           container_.file.size() - kTrailerSize);
  if (!after) return after;
  const Digest manifest =
      sha256(container_.file.subspan(header.manifest_offset, header.manifest_size));
  if (root_digest(manifest, header.incompatible_features, tiles, required) != header.root_digest) {
    return wrong_digest("the map", "byte 88");
  }
  return {};
}

// The section that names the factors tells how many there are before the layers are read.
void MapDecoder::expect_factors() {
  const schema::Block* names = find_section(container_, kFactorNames);
  if (names == nullptr || names->version() != kFactorNamesVersion) return;
  if (names->row_count() == 0 || names->row_count() > kMostFactors) return;
  has_factors_.resize(is_filled_.size());
  map_.factors.ranges_m = map_.ranges.ranges_m;
  map_.factors.factors.resize(names->row_count());
  map_.factors.site_count = map_.ranges.site_count;
  map_.factors.values.resize(is_filled_.size() * map_.ranges.ranges_m.size() * names->row_count());
}

Result<void> MapDecoder::check_factors() const {
  if (std::all_of(has_factors_.begin(), has_factors_.end(), [](bool has) { return has; })) {
    return {};
  }
  return Error{ErrorCode::kBadLayer, "factors are named, but some sites have none", "",
               "layer " + std::string(kFactorLayer)};
}

Result<CompiledMap> MapDecoder::run() {
  const Result<void> start = check_padding(kHeaderSize, container_.header.manifest_offset);
  if (!start) return start.error();
  const Result<void> counts = check_counts();
  if (!counts) return counts.error();
  const Result<void> manifest = decode_manifest(*container_.manifest, map_);
  if (!manifest) return manifest.error();
  const std::size_t sites = container_.manifest->site_count();
  const std::size_t ranges = map_.ranges.ranges_m.size();
  const std::size_t limits = map_.ranges.promises.size();
  is_filled_.resize(sites);
  map_.sites.sites.resize(sites);
  map_.ranges.site_count = map_.predicted.site_count = static_cast<std::uint32_t>(sites);
  map_.ranges.range_index.resize(sites * limits);
  map_.ranges.flags.resize(sites * limits);
  map_.predicted.mean_m.resize(sites * ranges);
  map_.predicted.within_probability.resize(sites * ranges * limits);
  map_.predicted.extrapolated.resize(sites);
  map_.predicted.out_of_fold.resize(sites);
  map_.predicted.has_history.resize(sites);
  expect_factors();
  const Result<void> visited = visit_all();
  if (!visited) return visited.error();
  const Result<void> valid = validate(map_);
  if (!valid) return valid.error();
  return std::move(map_);
}

MapSummary MapDecoder::summary() const {
  const FileHeader& header = container_.header;
  const schema::Manifest& manifest = *container_.manifest;
  MapSummary summary;
  summary.format = std::to_string(header.major) + "." + std::to_string(header.minor);
  summary.writer = manifest.writer()->str();
  summary.map_id = manifest.map_id()->str();
  summary.version = manifest.version()->str();
  summary.release = manifest.release();
  summary.root_digest = header.root_digest;
  summary.model_digest = from_schema(*manifest.model()->digest());
  summary.file_size = header.file_size;
  summary.manifest_size = header.manifest_size;
  summary.directory_size = header.directory_size;
  summary.tile_count = container_.directory->tiles()->size();
  for (const auto& [name, blocks] : blocks_) {
    summary.blocks.push_back(blocks);
    summary.blocks.back().name = name;
  }
  return summary;
}

// Bytes in memory may start anywhere; those of a file do not.
std::vector<double> aligned_copy(std::span<const std::byte> file) {
  std::vector<double> copy(file.size() / sizeof(double) + 1);
  std::copy(file.begin(), file.end(), std::as_writable_bytes(std::span(copy)).begin());
  return copy;
}

Result<std::pair<CompiledMap, MapSummary>> decode_aligned(std::span<const std::byte> file) {
  const Result<MapContainer> container = open_container(file);
  if (!container) return container.error();
  MapDecoder decoder(*container);
  Result<CompiledMap> map = decoder.run();
  if (!map) return map.error();
  return std::pair(std::move(*map), decoder.summary());
}

Result<std::pair<CompiledMap, MapSummary>> decode_bytes(std::span<const std::byte> file) {
  if (reinterpret_cast<std::uintptr_t>(file.data()) % 8 == 0) return decode_aligned(file);
  const std::vector<double> copy = aligned_copy(file);
  return decode_aligned(std::as_bytes(std::span(copy)).first(file.size()));
}

Result<std::pair<CompiledMap, MapSummary>> decode_file(const std::filesystem::path& path) {
  const Result<MappedFile> file = MappedFile::open(path.string());
  if (!file) return file.error();
  Result<std::pair<CompiledMap, MapSummary>> decoded = decode_aligned(file->bytes());
  if (decoded) return decoded;
  Error error = decoded.error();
  error.file = path.string();
  return error;
}

}  // namespace

Result<CompiledMap> read_map(const std::filesystem::path& path) {
  Result<std::pair<CompiledMap, MapSummary>> decoded = decode_file(path);
  if (!decoded) return decoded.error();
  return std::move(decoded->first);
}

Result<CompiledMap> read_map(std::span<const std::byte> file) {
  Result<std::pair<CompiledMap, MapSummary>> decoded = decode_bytes(file);
  if (!decoded) return decoded.error();
  return std::move(decoded->first);
}

Result<MapSummary> verify_map(const std::filesystem::path& path) {
  Result<std::pair<CompiledMap, MapSummary>> decoded = decode_file(path);
  if (!decoded) return decoded.error();
  return std::move(decoded->second);
}

Result<MapSummary> verify_map(std::span<const std::byte> file) {
  Result<std::pair<CompiledMap, MapSummary>> decoded = decode_bytes(file);
  if (!decoded) return decoded.error();
  return std::move(decoded->second);
}

}  // namespace sightline

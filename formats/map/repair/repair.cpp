#include "formats/map/repair/repair.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <map>
#include <utility>

#include "formats/map/block_decoder.h"
#include "formats/map/container/container_writer.h"
#include "formats/map/container/contents_layer.h"
#include "formats/map/container/packed_block.h"
#include "formats/map/drives_section.h"
#include "formats/map/factor_layer.h"
#include "formats/map/layers.h"
#include "formats/map/manifest.h"
#include "formats/map/map_reader.h"
#include "formats/map/site_columns.h"
#include "formats/reader/map_checks.h"
#include "formats/reader/map_container.h"
#include "formats/reader/map_layout.h"
#include "map_generated.h"

namespace sightline {
namespace {

std::vector<PackedTile> tiles_of_directory(const MapContainer& container) {
  std::vector<PackedTile> tiles;
  for (const schema::Tile* tile : *container.directory->tiles()) {
    tiles.push_back(packed_tile(container, *tile));
  }
  return tiles;
}

// A layer that leaves the file has no bytes, so that its checksum will not match.
PackedTile tile_behind(const TileContents& contents, std::span<const std::byte> rest) {
  PackedTile tile{contents.key, contents.digest, {}};
  for (const ContentsEntry& entry : contents.layers) {
    const bool is_inside =
        entry.offset <= rest.size() && entry.stored_size <= rest.size() - entry.offset;
    tile.layers.push_back(
        {entry.name, entry.version, entry.is_required, entry.codec, entry.row_count, entry.raw_size,
         entry.stored_checksum, entry.raw_digest,
         is_inside ? rest.subspan(entry.offset, entry.stored_size) : std::span<const std::byte>()});
  }
  return tile;
}

std::vector<PackedTile> self_described_tiles(const MapFront& front) {
  std::map<TileKey, PackedTile> tiles;
  const std::uint64_t begin = aligned(front.header.manifest_offset + front.header.manifest_size);
  for (std::uint64_t offset = begin; offset < front.file.size(); offset += kAlignment) {
    const std::span<const std::byte> rest = front.file.subspan(offset);
    const std::optional<TileContents> contents = decode_contents(rest);
    if (contents) tiles.emplace(contents->key, tile_behind(*contents, rest));
  }
  std::vector<PackedTile> sorted;
  for (auto& [key, tile] : tiles) sorted.push_back(std::move(tile));
  return sorted;
}

const PackedBlock* find_layer(const PackedTile& tile, std::string_view name) {
  const auto found = std::ranges::find(tile.layers, name, &PackedBlock::name);
  return found == tile.layers.end() ? nullptr : &*found;
}

Result<void> check_rows(const PackedBlock& layer, const schema::Manifest& manifest) {
  const bool is_ndt = layer.name == kNdtLayer && layer.version == kNdtLayerVersion;
  const bool is_range = layer.name == kRangeLayer && layer.version == kRangeLayerVersion &&
                        (layer.codec == BlockCodec::kNone || layer.codec == BlockCodec::kColumns);
  if ((!is_ndt && !is_range) || layer.row_count == 0 || layer.row_count > kMostRows) {
    return Error{ErrorCode::kBadLayer, "layer " + layer.name + " is of an unknown kind"};
  }
  const std::uint64_t expected = is_ndt ? NdtLayout(layer.row_count).size
                                        : RangeLayout(layer.row_count, answer_shape(manifest)).size;
  if (layer.raw_size == expected) return {};
  return Error{ErrorCode::kBadLayer, "layer " + layer.name + " has another size than its rows"};
}

// Every required layer is what the tile's digest names.
Result<void> check_tile(const PackedTile& tile, const schema::Manifest& manifest) {
  for (const PackedBlock& layer : tile.layers) {
    const bool must_be_required = layer.name == kNdtLayer || layer.name == kRangeLayer;
    if (!layer.is_required && must_be_required) {
      return Error{ErrorCode::kBadLayer, "layer " + layer.name + " is marked optional"};
    }
    if (!layer.is_required) continue;
    SIGHTLINE_TRY(check_rows(layer, manifest));
    SIGHTLINE_TRY(checked_bytes(layer));
  }
  if (required_digest(tile) == tile.digest) return {};
  return wrong_digest("the tile", "");
}

// The ids of the sites that are left, ascending: a site's new id is its place among them.
using SiteIds = std::vector<std::uint32_t>;

SiteIds sites_of(const std::vector<PackedTile>& tiles) {
  SiteIds ids;
  for (const PackedTile& tile : tiles) {
    const PackedBlock* layer = find_layer(tile, kRangeLayer);
    if (layer == nullptr) continue;
    const Result<RawBytes> raw = checked_bytes(*layer);  // as check_tile() did
    if (!raw) continue;
    const std::size_t before = ids.size();
    ids.resize(before + layer->row_count);
    std::memcpy(ids.data() + before, raw->bytes().data(), layer->row_count * sizeof ids[0]);
  }
  std::ranges::sort(ids);
  return ids;
}

// The first column of a layer of sites is their ids.
std::vector<std::byte> renumbered(std::span<const std::byte> raw, std::uint64_t row_count,
                                  const SiteIds& ids) {
  std::vector<std::byte> changed(raw.begin(), raw.end());
  row_count = std::min<std::uint64_t>(row_count, raw.size() / sizeof ids[0]);
  for (std::uint64_t row = 0; row < row_count; ++row) {
    std::uint32_t id = 0;
    std::memcpy(&id, raw.data() + row * sizeof id, sizeof id);
    id = static_cast<std::uint32_t>(std::ranges::lower_bound(ids, id) - ids.begin());
    std::memcpy(changed.data() + row * sizeof id, &id, sizeof id);
  }
  return changed;
}

// Its sites numbered anew.
Result<void> decode_layer(const PackedTile& tile, std::string_view name, const SiteIds& ids,
                          BlockDecoder& decoder) {
  const PackedBlock* layer = find_layer(tile, name);
  if (layer == nullptr) return {};
  SIGHTLINE_ASSIGN(const RawBytes raw, checked_bytes(*layer));
  if (name == kNdtLayer) return decoder.decode_layer(*layer, raw.bytes(), tile.key);
  return decoder.decode_layer(*layer, renumbered(raw.bytes(), layer->row_count, ids), tile.key);
}

Result<void> decode_layers(const std::vector<PackedTile>& tiles,
                           std::initializer_list<std::string_view> names, const SiteIds& ids,
                           BlockDecoder& decoder) {
  for (const PackedTile& tile : tiles) {
    for (const std::string_view name : names) {
      SIGHTLINE_TRY(decode_layer(tile, name, ids, decoder));
    }
  }
  return {};
}

// A run ends where sites are missing, and arc length begins anew.
void cut_runs(const SiteIds& ids, Sites& sites) {
  std::uint32_t run = 0;
  std::uint32_t run_before = 0;
  double start_m = 0.0;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    Site& site = sites.sites[i];
    if (i == 0 || ids[i] != ids[i - 1] + 1 || site.run != run_before) {
      run += i == 0 ? 0 : 1;
      start_m = site.s_m;
    }
    run_before = std::exchange(site.run, run);
    site.s_m -= start_m;
  }
}

Result<void> decode_section(const MapContainer& container, std::string_view name,
                            BlockDecoder& decoder) {
  const schema::Block* entry = find_section(container, name);
  if (entry == nullptr) return {};
  const PackedBlock section = packed_block(container, *entry);
  SIGHTLINE_ASSIGN(const RawBytes raw, checked_bytes(section));
  return decoder.decode_section(section, raw.bytes());
}

// All of them, or none.
Result<void> decode_factors(const MapContainer& container, const std::vector<PackedTile>& tiles,
                            const SiteIds& ids, BlockDecoder& decoder) {
  decoder.expect_factors(container);
  SIGHTLINE_TRY(decode_section(container, kFactorNames, decoder));
  SIGHTLINE_TRY(decode_section(container, kSampleFactorNames, decoder));
  SIGHTLINE_TRY(decode_layers(tiles, {kFactorLayer, kSampleFactorLayer}, ids, decoder));
  SIGHTLINE_TRY(decoder.check_factors());
  decoder.take_factors();
  return {};
}

// Its values at the sites that are left.
Result<void> decode_column(const MapContainer& container, const SiteIds& ids, SiteColumn& column) {
  const schema::Block* entry = find_section(container, column_section(column.name));
  if (entry == nullptr || entry->version() != column_version(!column.steps.empty())) {
    return Error{ErrorCode::kBadLayer, "it is missing"};
  }
  SIGHTLINE_ASSIGN(const RawBytes raw, checked_bytes(packed_block(container, *entry)));
  SIGHTLINE_TRY(check_column(container, column.name, raw.bytes()));
  SiteColumn whole = column;
  SIGHTLINE_TRY(decode_column(raw.bytes(), container.manifest->site_count(), whole));
  for (const std::uint32_t id : ids) {
    if (id >= whole.values.size()) return Error{ErrorCode::kBadLayer, "it has too few sites"};
    column.values.push_back(whole.values[id]);
  }
  return validate(column);
}

void note_fault(const std::string& what, const Result<void>& result,
                std::vector<std::string>& lost) {
  if (!result) lost.push_back(what + ": " + to_string(result.error()));
}

// Blocks that can be found through the directory alone.
void decode_for_engineers(const Result<MapContainer>& container,
                          const std::vector<PackedTile>& tiles, const SiteIds& ids,
                          BlockDecoder& decoder, std::vector<std::string>& lost) {
  if (!container) {
    return lost.push_back(
        "the factors, the error model and the drives of each tile, if the map had them: the "
        "directory is lost");
  }
  note_fault("the factors", decode_factors(*container, tiles, ids, decoder), lost);
  note_fault("the drives of each tile", decode_section(*container, kDrivesSection, decoder), lost);
  note_fault("the error model", decode_section(*container, kModelSection, decoder), lost);
}

// Those that cannot be read are left out.
void decode_columns(const Result<MapContainer>& container, const SiteIds& ids, CompiledMap& map,
                    std::vector<std::string>& lost) {
  std::vector<SiteColumn> left;
  for (SiteColumn& column : map.columns) {
    const Result<void> decoded =
        container ? decode_column(*container, ids, column) : Result<void>(container.error());
    note_fault("the column " + column.name, decoded, lost);
    if (decoded) left.push_back(std::move(column));
  }
  map.columns = std::move(left);
}

void note_counts(const schema::Manifest& manifest, const CompiledMap& map,
                 std::vector<std::string>& lost) {
  const std::uint64_t nds = map.ndt.nds.size();
  const std::uint64_t sites = map.sites.sites.size();
  if (nds == manifest.nd_count() && sites == manifest.site_count()) return;
  lost.push_back(concat("kept ", sites, " of ", manifest.site_count(), " sites and ", nds, " of ",
                        manifest.nd_count(), " NDs"));
}

// Figures of the whole map are withdrawn.
void mark_as_part(const SiteIds& ids, CompiledMap& map) {
  cut_runs(ids, map.sites);
  map.version += ", recovered";
  map.measurement.measured_site_count = 0;
  map.quality = quality_of(map.predicted, map.ranges, nullptr);
  if (map.looks) map.looks->quality = quality_of(map.looks->predicted, map.looks->ranges, nullptr);
}

// The recordings without the sketches of their scans; as it is where it is of another version.
Result<SelfContainedBlock> without_sketches(const PackedBlock& block) {
  SIGHTLINE_ASSIGN(const RawBytes raw, checked_bytes(block));
  SIGHTLINE_ASSIGN(RecordingCards recordings, decode_recordings(raw.bytes(), block.row_count));
  for (RecordingCard& card : recordings.cards) card.scans.clear();
  return packed(
      {block.name, block.version, false, block.row_count, true, encode_recordings(recordings)});
}

using Keep = std::function<bool(const PackedBlock&)>;

std::vector<PackedBlock> kept_blocks(const MapContainer& container, const auto& entries,
                                     const Keep& keep) {
  std::vector<PackedBlock> blocks;
  for (const schema::Block* entry : entries) {
    PackedBlock block = packed_block(container, *entry);
    if (!is_derived(block.name) && keep(block)) blocks.push_back(std::move(block));
  }
  return blocks;
}

// All of the directory's features but the one that the writer sets.
std::vector<FeatureParts> features_of(const MapContainer& container) {
  std::vector<FeatureParts> features;
  for (const schema::Feature* feature : *container.directory->features()) {
    if (!feature->is_required() && feature->bit() == kLookUpFeatureBit) continue;
    features.push_back({feature->bit(), feature->is_required(), feature->name()->str()});
  }
  return features;
}

Result<std::vector<std::byte>> repack(const MapContainer& container, const Keep& keep) {
  std::vector<std::byte> file;
  file.reserve(container.file.size());
  const FileHeader& header = container.header;
  const std::span<const std::byte> manifest =
      container.file.subspan(header.manifest_offset, header.manifest_size);
  ContainerWriter writer(write_to(file), {manifest.begin(), manifest.end()},
                         features_of(container));
  for (const schema::Tile* tile : *container.directory->tiles()) {
    const Result<void> added =
        writer.add_tile({tile->x(), tile->y()}, kept_blocks(container, *tile->layers(), keep));
    SIGHTLINE_CHECK(added);
  }
  for (const PackedBlock& section :
       kept_blocks(container, *container.directory->sections(), keep)) {
    if (section.name == kRecordingsSection && section.version == kRecordingsSectionVersion) {
      SIGHTLINE_ASSIGN(const SelfContainedBlock own, without_sketches(section));
      SIGHTLINE_CHECK(writer.add_section(own.block));
      continue;
    }
    SIGHTLINE_CHECK(writer.add_section(section));
  }
  const Result<Digest> root = writer.finish();
  SIGHTLINE_CHECK(root && *root == header.root_digest);
  return file;
}

bool is_for_engineers(const PackedBlock& block) {
  constexpr std::string_view kNames[] = {kFactorLayer,       kFactorNames, kSampleFactorLayer,
                                         kSampleFactorNames, "debug",      kModelSection};
  return !block.is_required && std::ranges::find(kNames, block.name) != std::end(kNames);
}

}  // namespace

Result<Recovered> recover_map(std::span<const std::byte> file) {
  SIGHTLINE_ASSIGN(const MapFront front, open_front_alone(file));
  Recovered recovered;
  SIGHTLINE_TRY(decode_manifest(*front.manifest, recovered.map));
  const Result<MapContainer> container = open_directory(front);
  if (!container) recovered.lost.push_back("the directory: " + to_string(container.error()));
  std::vector<PackedTile> tiles =
      container ? tiles_of_directory(*container) : self_described_tiles(front);
  std::erase_if(tiles, [&](const PackedTile& tile) {
    const Result<void> checked = check_tile(tile, *front.manifest);
    note_fault(tile_place(tile.key.x, tile.key.y), checked, recovered.lost);
    return !checked;
  });
  const SiteIds ids = sites_of(tiles);
  if (ids.empty()) {
    return Error{ErrorCode::kTruncatedFile, "no site is readable; compile the map again"};
  }
  BlockDecoder decoder(ids.size(), recovered.map);
  SIGHTLINE_TRY(decode_layers(tiles, {kNdtLayer, kRangeLayer}, ids, decoder));
  decode_for_engineers(container, tiles, ids, decoder, recovered.lost);
  decode_columns(container, ids, recovered.map, recovered.lost);
  const bool is_part = recovered.map.ndt.nds.size() != front.manifest->nd_count() ||
                       ids.size() != front.manifest->site_count();
  note_counts(*front.manifest, recovered.map, recovered.lost);
  if (is_part) mark_as_part(ids, recovered.map);
  SIGHTLINE_TRY(validate(recovered.map));
  return recovered;
}

Result<Repacked> strip_map(std::span<const std::byte> file) {
  SIGHTLINE_TRY(verify_map(file));
  SIGHTLINE_ASSIGN(const MapContainer container, open_container(file));
  std::map<std::string, std::uint64_t> dropped;
  const auto keep = [&](const PackedBlock& block) {
    if (!is_for_engineers(block)) return true;
    dropped[block.name] += block.stored.size();
    return false;
  };
  SIGHTLINE_ASSIGN(std::vector<std::byte> stripped, repack(container, keep));
  Repacked result{std::move(stripped), {}};
  for (const auto& [name, bytes] : dropped) {
    result.actions.push_back("dropped " + name + ", " + std::to_string(bytes) + " bytes");
  }
  if (dropped.empty()) result.actions.emplace_back("there was nothing to drop");
  return result;
}

}  // namespace sightline

#include "formats/map/tiles/map_tiles.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <utility>

#include "formats/map/container/packed_block.h"
#include "formats/map/layers.h"
#include "formats/map/manifest.h"
#include "formats/reader/map_checks.h"
#include "formats/reader/map_container.h"
#include "map_generated.h"

namespace sightline {
namespace {

Error in_file(Error error, const std::filesystem::path& path) {
  error.file = path.string();
  return error;
}

// Of the digests that manifest and directory contain: the tiles themselves are not read.
Result<void> check_root_digest(const MapContainer& container) {
  const FileHeader& header = container.header;
  std::vector<Digest> tiles;
  tiles.reserve(container.directory->tiles()->size());
  for (const schema::Tile* tile : *container.directory->tiles()) {
    tiles.push_back(to_digest(*tile->digest()));
  }
  const Digest manifest =
      sha256(container.file.subspan(header.manifest_offset, header.manifest_size));
  if (root_digest(manifest, header.incompatible_features, tiles, {}) == header.root_digest) {
    return {};
  }
  return wrong_digest("the map", "byte 88");
}

// Bytes of a mapped file that were read: the process no longer holds their pages, the system may.
void release_pages(std::span<const std::byte> bytes) {
  static const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const std::uintptr_t begin = reinterpret_cast<std::uintptr_t>(bytes.data()) / page * page;
  const std::uintptr_t end = reinterpret_cast<std::uintptr_t>(bytes.data()) + bytes.size();
  (void)::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);
}

}  // namespace

Result<MapTiles> MapTiles::open(const std::filesystem::path& path) {
  MapTiles map;
  map.path_ = path;
  SIGHTLINE_ASSIGN(map.file_, MappedFile::open(path.string(), MappedFile::Use::kHereAndThere));
  const Result<MapContainer> container = open_container(map.file_.bytes());
  if (!container) return in_file(container.error(), path);
  map.container_ = *container;
  const Result<void> digest = check_root_digest(map.container_);
  if (!digest) return in_file(digest.error(), path);
  const Result<void> decoded = decode_manifest(*map.container_.manifest, map.head_);
  if (!decoded) return in_file(decoded.error(), path);
  const Result<void> sensor = validate(map.head_.sensor);
  if (!sensor) return in_file(sensor.error(), path);
  const auto& tiles = *map.container_.directory->tiles();
  for (std::uint32_t number = 0; number < tiles.size(); ++number) {
    if (find_layer(map.container_, number, kNdtLayer) == nullptr) continue;
    map.keys_.push_back({tiles.Get(number)->x(), tiles.Get(number)->y()});
    map.numbers_.push_back(number);
  }
  return map;
}

Result<std::vector<Nd>> MapTiles::decoded(std::size_t number) const {
  const std::uint32_t place = numbers_[number];
  const PackedTile tile = packed_tile(container_, *container_.directory->tiles()->Get(place));
  if (required_digest(tile) != tile.digest) return wrong_digest("the tile", "");
  const PackedBlock block = packed_block(container_, *find_layer(container_, place, kNdtLayer));
  SIGHTLINE_ASSIGN(const RawBytes raw, checked_bytes(block));
  if (block.codec != BlockCodec::kNone) release_pages(block.stored);
  NdtMap of_tile = head_.ndt;
  SIGHTLINE_TRY(decode_ndt_layer(raw.bytes(), block.row_count, tile.key, of_tile));
  SIGHTLINE_TRY(validate(of_tile));
  return std::move(of_tile.nds);
}

Result<std::vector<Nd>> MapTiles::nds(std::size_t number) const {
  Result<std::vector<Nd>> nds = decoded(number);
  if (nds) return nds;
  Error error = in_file(nds.error(), path_);
  const TileKey& key = keys_[number];
  const std::string place = tile_place(key.x, key.y);
  error.place = error.place.empty() ? place : place + ", " + error.place;
  return error;
}

}  // namespace sightline

#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "formats/map/compiled_map.h"
#include "formats/reader/mapped_file.h"
#include "formats/reader/opened_map.h"

namespace sightline {

// A map file whose NDs are read and checked tile by tile, when they are needed.
class MapTiles {
 public:
  // Reads and checks header, trailer, manifest, directory and the digest of the map, whatever its
  // length; reads no tile. Errors: those of open_container(); digest-mismatch, invalid-artifact,
  // file-not-found, cannot-open, cannot-read.
  static Result<MapTiles> open(const std::filesystem::path& path);

  // What the manifest contains: no NDs, sites or predictions.
  [[nodiscard]] const CompiledMap& head() const { return head_; }
  // Of the tiles that have NDs, ascending.
  [[nodiscard]] std::span<const TileKey> keys() const { return keys_; }

  // The NDs of the tile with that number among the keys, in the order of the map. Checks their
  // bytes and the tile's digest. Safe from several threads. Errors, with the tile as the place:
  // checksum-mismatch, digest-mismatch, bad-layer, bad-order, too-large, invalid-artifact.
  [[nodiscard]] Result<std::vector<Nd>> nds(std::size_t number) const;

 private:
  [[nodiscard]] Result<std::vector<Nd>> decoded(std::size_t number) const;

  MappedFile file_;
  MapContainer container_;  // refers into the file
  CompiledMap head_;
  std::vector<TileKey> keys_;
  std::vector<std::uint32_t> numbers_;  // of these tiles in the directory
  std::filesystem::path path_;
};

}  // namespace sightline

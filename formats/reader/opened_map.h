#pragma once

#include <cstddef>
#include <span>

#include "formats/reader/map_layout.h"

// A compiled map as far as it has been opened: what map_container.h finds in its bytes.

namespace sightline {

namespace schema {  // generated from schemas/map.fbs
struct Block;
struct Directory;
struct Manifest;
struct Tile;
}  // namespace schema

// A compiled map whose header, trailer and manifest have been checked. Refers into the bytes it was
// opened on.
struct MapFront {
  std::span<const std::byte> file;
  FileHeader header;
  const schema::Manifest* manifest = nullptr;
};

// The same with its directory. Layers and sections have only been located: stored_bytes() checks
// one.
struct MapContainer {
  std::span<const std::byte> file;
  FileHeader header;
  const schema::Manifest* manifest = nullptr;
  const schema::Directory* directory = nullptr;
};

}  // namespace sightline

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/artifact.h"
#include "formats/grid/cell_key.h"

// Which drives a map of several is made of, tile by tile: so the map says from which days a tile
// is.

namespace sightline {

// A drive of the map, with the stamps of its first and last scan as the map's drives were joined.
struct MappedDrive {
  std::string name;
  std::int64_t begin_ns = 0;
  std::int64_t end_ns = 0;
  friend bool operator==(const MappedDrive&, const MappedDrive&) = default;
};

// The date in UTC, "2026-05-04"; empty where times are counted from the beginning of a recording.
std::string day_of(std::int64_t stamp_ns);

// A drive whose returns stand in a tile.
struct TileDrive {
  TileKey tile;
  std::uint32_t drive = 0;
  std::uint32_t scan_count = 0;  // that the pass count-drives counts; at least 1
  friend bool operator==(const TileDrive&, const TileDrive&) = default;
};

struct TileDrives {
  double tile_m = 64.0;
  std::vector<MappedDrive> drives;  // in the order in which they were named
  std::vector<TileDrive> rows;      // ascending by tile, then drive
  friend bool operator==(const TileDrives&, const TileDrives&) = default;
};

template <>
struct ArtifactTraits<TileDrives> {
  static constexpr std::string_view kName = "tile-drives";
  static constexpr std::uint32_t kVersion = 1;
};

// Error: invalid-artifact.
Result<void> validate(const TileDrives& tiles);
Table dump(const TileDrives& tiles);  // a row for each tile and drive
// The section `drives` of a map (schemas/map_format.md) is these bytes.
void encode(const TileDrives& tiles, ByteWriter& writer);
void decode(ByteReader& reader, TileDrives& tiles);

}  // namespace sightline

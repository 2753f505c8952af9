#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/artifact.h"
#include "formats/grid/cell_key.h"
#include "formats/record/fields.h"

// Which drives a map of several is made of, tile by tile, and which found nothing new there: so the
// map says from which days a tile is, and when somebody last saw that it still looks so.

namespace sightline {

// A drive of the map, with the stamps of its first and last scan as the map's drives were joined.
struct MappedDrive {
  std::string name;
  std::int64_t begin_ns = 0;
  std::int64_t end_ns = 0;
  friend bool operator==(const MappedDrive&, const MappedDrive&) = default;
};
SIGHTLINE_FIELDS(MappedDrive, name, begin_ns, end_ns)

// The date in UTC, "2026-05-04"; empty where times are counted from the beginning of a recording.
std::string day_of(std::int64_t stamp_ns);

// A drive whose returns stand in a tile, or that found nothing new in it. Scans are those that the
// pass count-drives counts; at least one count is not 0.
struct TileDrive {
  TileKey tile;
  std::uint32_t drive = 0;
  std::uint32_t scan_count = 0;             // of those in the map, with returns in the tile
  std::uint32_t confirming_scan_count = 0;  // taken in the tile, not laid: they show nothing new
  friend bool operator==(const TileDrive&, const TileDrive&) = default;
};
SIGHTLINE_FIELDS(TileDrive, tile, drive, scan_count, confirming_scan_count)

struct TileDrives {
  double tile_m = 64.0;
  std::vector<MappedDrive> drives;  // in the order in which they were named
  std::vector<TileDrive> rows;      // ascending by tile, then drive
  friend bool operator==(const TileDrives&, const TileDrives&) = default;
};
SIGHTLINE_FIELDS(TileDrives, tile_m, drives, rows)
SIGHTLINE_ARTIFACT(TileDrives, "tile-drives", 2)

// Error: invalid-artifact.
Result<void> validate(const TileDrives& tiles);
Table dump(const TileDrives& tiles);  // a row for each tile and drive
// The section `drives` of a map (schemas/map_format.md) has these bytes and this version. Version 1
// had no confirming scans.
void decode_version_1(ByteReader& reader, TileDrives& tiles);

}  // namespace sightline

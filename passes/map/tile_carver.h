#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/result.h"
#include "formats/grid/point_grid.h"
#include "formats/surroundings/surface_points.h"
#include "passes/map/moving_verdict.h"

namespace sightline {

struct CarveOptions {
  double voxel_m = 0.2;
  double carve_range_m = 60.0;
  double tile_m = 128.0;
};

struct ReturnCounts {
  std::uint64_t in_range = 0;  // of the sensor
  std::uint64_t out_of_range = 0;
};
SIGHTLINE_FIELDS(ReturnCounts, in_range, out_of_range)

// What moved within one tile; see remove_moving.
struct TileFindings {
  ReturnCounts of_scans;              // all returns of the scans that were taken in the tile
  std::uint64_t moving_count = 0;     // returns in the voxels that moved
  std::vector<CellKey> moved_voxels;  // ascending
};
SIGHTLINE_FIELDS(TileFindings, of_scans, moving_count, moved_voxels)

// Where the scans' sensors were, in their order.
PointGrid origins_of(std::span<const PlacedScan> scans);

// Those that may reach a tile or look into it, in their order. `origins` are of the scans.
std::vector<PlacedScan> scans_of_tile(const CarveOptions& options,
                                      std::span<const PlacedScan> scans, const PointGrid& origins,
                                      const TileKey& tile);

// Looks at one tile with all scans that reach it, one scan in memory at a time. The findings do not
// depend on the tiling. Errors: those of reading a scan.
Result<TileFindings> find_moving_in_tile(const CarveOptions& options, const ScanStore& store,
                                         std::span<const PlacedScan> scans, const TileKey& tile);

// What later drives say of a square of the plane, in voxels (DriveEvidence::compare).
struct ComparedSquare {
  TileKey square;
  std::uint32_t confirmed = 0;
  std::uint32_t changed = 0;
};
SIGHTLINE_FIELDS(ComparedSquare, square, confirmed, changed)

// The squares of one tile, a multiple of them, in which the parts of the drive from `first_new` on
// confirm or contradict those before; ascending. Errors: what reading a scan says.
Result<std::vector<ComparedSquare>> compare_in_tile(const CarveOptions& options,
                                                    const ScanStore& store,
                                                    std::span<const PlacedScan> scans,
                                                    const TileKey& tile, std::uint32_t first_new,
                                                    double square_m);

// The voxels of a tile and of those around it, before any verdict: hits, misses, and which are
// ground. Voxels that stand in any case have no misses. Errors: those of reading a scan.
Result<SeenVoxels> look_at_tile(const CarveOptions& options, const ScanStore& store,
                                std::span<const PlacedScan> scans, const TileKey& tile);

// The tiles in which something can be found, ascending: those within the carving range of a scan.
std::vector<TileKey> tiles_to_look_at(const CarveOptions& options,
                                      std::span<const PlacedScan> scans);

}  // namespace sightline

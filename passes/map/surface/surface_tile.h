#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <vector>

#include "formats/base/files/stored_bytes.h"
#include "formats/base/result.h"
#include "formats/surroundings/surface.h"
#include "formats/surroundings/surface_points.h"
#include "passes/map/tiles/build_ndt_cells.h"
#include "passes/map/tiles/cell_tiles.h"

namespace sightline {

struct SurfaceTileOptions {
  double cell_m = 0.5;
  double tile_m = 64.0;  // by which patches are ordered
  int min_points = 3;
  double returns_per_ray = 1.0;  // of all scans, in sixteenths
};

// What one tile gives of a surface.
struct SurfaceTile {
  CellTally cells;                    // of at least two points
  std::vector<SurfacePatch> patches;  // ascending by order_of()
};
SIGHTLINE_FIELDS(SurfaceTile, cells, patches)

// The patches whose centres lie over a tile, but for ground between ground: those of the surface of
// all scans, to the bit. `tiles`: of cells of the options, blocks a multiple of kLongestCell_cells.
// As many scans in memory as threads (0: all there are). Errors: those of reading a scan.
Result<SurfaceTile> surface_of_tile(const SurfacePoints& points, const SurfaceTileOptions& options,
                                    const CellTiles& tiles, std::size_t tile, int threads);

// What decides it (PartedWork::content).
std::optional<Digest> content_of_tile(const SurfacePoints& points,
                                      const SurfaceTileOptions& options, const CellTiles& tiles,
                                      std::size_t tile);

// Ascending by order_of() in a surface of such cells and tiles, each asked about once.
void sort_patches(const Surface& surface, std::vector<SurfacePatch>& patches);

// Patches that come in any order and are wanted tile by tile, in memory as far as they are few.
class PatchesByTile {
 public:
  PatchesByTile(double cell_m, double tile_m) : order_{{}, cell_m, tile_m, {}} {}

  // Safe from several threads. A failure is returned by finish().
  void add(std::span<const SurfacePatch> patches);
  // After the last add() and before what follows. Errors: disk-full, cannot-write.
  [[nodiscard]] Result<void> finish();

  // That hold patches, ascending.
  [[nodiscard]] std::vector<TileKey> tiles() const;
  // The patches of a tile, ascending by order_of(). Error: cannot-read.
  [[nodiscard]] Result<std::vector<SurfacePatch>> of_tile(const TileKey& tile) const;
  // Those with centres over a box of the plane, ascending by order_of(). Error: cannot-read.
  [[nodiscard]] Result<std::vector<SurfacePatch>> over(const Eigen::AlignedBox2d& box_m) const;

 private:
  struct Piece {
    std::uint64_t first = 0;  // among all patches
    std::uint64_t count = 0;
  };

  // In any order.
  [[nodiscard]] Result<std::vector<SurfacePatch>> read(const TileKey& tile) const;

  Surface order_;  // no patches: what order_of() asks for
  std::mutex mutex_;
  std::map<TileKey, std::vector<Piece>> pieces_;
  std::uint64_t count_ = 0;
  static constexpr std::size_t kMostInMemory = std::size_t{16} << 20;  // of half a kilometre
  GrowingBytes growing_{kMostInMemory};
  Result<void> written_;
  StoredBytes bytes_;
};

}  // namespace sightline

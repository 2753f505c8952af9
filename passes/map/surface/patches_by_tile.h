#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/files/stored_bytes.h"
#include "formats/surroundings/surface.h"

namespace sightline {

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

#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/artifact_in_pieces.h"
#include "formats/base/files/stored_bytes.h"
#include "formats/surroundings/surface.h"

namespace sightline {

// The patches of a surface whose cells lie in one tile, as places among all patches.
struct PatchTile {
  TileKey key;
  std::uint64_t first = 0;
  std::uint64_t count = 0;
};

// A surface of which tiles are read when they are looked at, so that a street of any length takes
// no more memory than a stretch of it. Safe from several threads.
class TiledSurface {
 public:
  TiledSurface() = default;
  // Who has a surface whole may hand it over where one in tiles is taken; patches in any order.
  TiledSurface(const Surface& whole);  // NOLINT(google-explicit-constructor)

  [[nodiscard]] const MapFrame& frame() const { return frame_; }
  [[nodiscard]] double cell_m() const { return cell_m_; }
  [[nodiscard]] double tile_m() const { return tile_m_; }
  // Half the side of the widest patch; 0 where there is none.
  [[nodiscard]] double widest_half_side_m() const { return widest_half_side_m_; }
  [[nodiscard]] std::uint64_t patch_count() const { return patch_count_; }
  // That hold patches, ascending by key.
  [[nodiscard]] std::span<const PatchTile> tiles() const { return tiles_; }

  // The patches of one tile. Error: cannot-read, as of all that follow.
  [[nodiscard]] Result<Surface> tile(const PatchTile& tile) const;
  // Of all tiles that a box of the plane touches: all patches whose centres lie over it, and more.
  [[nodiscard]] Result<Surface> over(const Eigen::AlignedBox2d& box_m) const;
  [[nodiscard]] Result<Surface> whole() const;

 private:
  friend class TiledSurfaceWriter;
  friend std::uint64_t payload_size(const TiledSurface& surface);
  friend Result<void> visit_payload(const TiledSurface& surface, const ByteSink& sink);
  friend Result<void> open_payload(const StoredBytes& payload, TiledSurface& surface);

  [[nodiscard]] Surface empty() const { return {frame_, cell_m_, tile_m_, {}}; }
  [[nodiscard]] Result<void> append(const PatchTile& tile, Surface& surface) const;

  MapFrame frame_;
  double cell_m_ = 0.0;
  double tile_m_ = 0.0;
  double widest_half_side_m_ = 0.0;
  std::uint64_t patch_count_ = 0;
  std::vector<PatchTile> tiles_;
  StoredBytes patches_;  // encoded, tile after tile
};

// Makes one tile after another.
class TiledSurfaceWriter {
 public:
  TiledSurfaceWriter(const MapFrame& frame, double cell_m, double tile_m);

  // The patches of the next tile, ascending by order_of(); tiles ascend too. None: no tile.
  // Errors: disk-full, cannot-write.
  [[nodiscard]] Result<void> add(const TileKey& key, std::span<const SurfacePatch> patches);
  [[nodiscard]] TiledSurface take();

 private:
  TiledSurface made_;
  static constexpr std::size_t kMostInMemory = std::size_t{16} << 20;  // of half a kilometre
  GrowingBytes bytes_{kMostInMemory};
};

template <>
struct ArtifactTraits<TiledSurface> {
  static constexpr std::string_view kName = "surface";
  static constexpr std::uint32_t kVersion = 4;
};

// Reads every tile.
Result<void> validate(const TiledSurface& surface);
Table dump(const TiledSurface& surface);

std::uint64_t payload_size(const TiledSurface& surface);
Result<void> visit_payload(const TiledSurface& surface, const ByteSink& sink);
Result<void> open_payload(const StoredBytes& payload, TiledSurface& surface);

}  // namespace sightline

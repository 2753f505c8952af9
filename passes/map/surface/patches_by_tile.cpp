#include "passes/map/surface/patches_by_tile.h"

#include "formats/base/bytes.h"
#include "passes/map/surface/sort_patches.h"

namespace sightline {

void PatchesByTile::add(std::span<const SurfacePatch> patches) {
  std::map<TileKey, std::vector<const SurfacePatch*>> of_tile;
  for (const SurfacePatch& patch : patches) {
    of_tile[tile_of(patch.key, order_.cell_m, order_.tile_m)].push_back(&patch);
  }
  ByteWriter writer;
  writer.reserve(patches.size() * kEncodedPatch);
  for (const auto& [tile, members] : of_tile) {
    for (const SurfacePatch* patch : members) encode(*patch, writer);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& [tile, members] : of_tile) {
    pieces_[tile].push_back({count_, members.size()});
    count_ += members.size();
  }
  if (written_) written_ = growing_.append(writer.bytes());
}

Result<void> PatchesByTile::finish() {
  SIGHTLINE_TRY(written_);
  bytes_ = growing_.take();
  return {};
}

std::vector<TileKey> PatchesByTile::tiles() const {
  std::vector<TileKey> tiles;
  for (const auto& [tile, pieces] : pieces_) tiles.push_back(tile);
  return tiles;
}

Result<std::vector<SurfacePatch>> PatchesByTile::read(const TileKey& tile) const {
  std::vector<SurfacePatch> patches;
  const auto found = pieces_.find(tile);
  if (found == pieces_.end()) return patches;
  for (const Piece& piece : found->second) {
    SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes,
                     bytes_.read(piece.first * kEncodedPatch, piece.count * kEncodedPatch));
    ByteReader reader(bytes);
    for (std::uint64_t i = 0; i < piece.count; ++i) decode(reader, patches.emplace_back());
  }
  return patches;
}

Result<std::vector<SurfacePatch>> PatchesByTile::of_tile(const TileKey& tile) const {
  SIGHTLINE_ASSIGN(std::vector<SurfacePatch> patches, read(tile));
  sort_patches(order_, patches);
  return patches;
}

Result<std::vector<SurfacePatch>> PatchesByTile::over(const Eigen::AlignedBox2d& box_m) const {
  std::vector<SurfacePatch> patches;
  const auto tile_at = [&](const Eigen::Vector2d& corner_m) {
    return tile_key({corner_m.x(), corner_m.y(), 0.0}, order_.tile_m);
  };
  const TileKey low = tile_at(box_m.min());
  const TileKey high = tile_at(box_m.max());
  for (std::int32_t x = low.x; x <= high.x; ++x) {
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      SIGHTLINE_ASSIGN(const std::vector<SurfacePatch> of_tile, read({x, y}));
      for (const SurfacePatch& patch : of_tile) {
        const Eigen::Vector2d at_m = patch.centre_m.head<2>();
        if (box_m.contains(at_m)) patches.push_back(patch);
      }
    }
  }
  sort_patches(order_, patches);
  return patches;
}

}  // namespace sightline

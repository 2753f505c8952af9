#include "formats/surroundings/tiled_surface.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "formats/base/check.h"

namespace sightline {
namespace {

constexpr std::size_t kEncodedTile = 2 * sizeof(std::int32_t) + sizeof(std::uint64_t);

Error invalid_tile(std::string message, const TileKey& tile) {
  return {ErrorCode::kInvalidArtifact, std::move(message), "",
          "tile " + std::to_string(tile.x) + ", " + std::to_string(tile.y)};
}

// What precedes the patches.
std::vector<std::byte> head_of(const TiledSurface& surface) {
  ByteWriter writer;
  encode(surface.frame(), writer);
  writer.put(surface.cell_m());
  writer.put(surface.tile_m());
  writer.put(surface.widest_half_side_m());
  writer.put<std::uint64_t>(surface.tiles().size());
  for (const PatchTile& tile : surface.tiles()) {
    writer.put(tile.key.x);
    writer.put(tile.key.y);
    writer.put(tile.count);
  }
  return writer.take();
}

Result<void> validate_tile(const TiledSurface& surface, const PatchTile& tile) {
  SIGHTLINE_ASSIGN(const Surface of_tile, surface.tile(tile));
  const auto in_tile = [&](Error error) {
    error.place = invalid_tile("", tile.key).place + ", " + error.place;
    return error;
  };
  const Result<void> checked = validate(of_tile);
  if (!checked) return in_tile(checked.error());
  for (const SurfacePatch& patch : of_tile.patches) {
    if (tile_of(patch.key, surface.cell_m(), surface.tile_m()) != tile.key) {
      return invalid_tile("a patch lies in another tile", tile.key);
    }
    if (patch.half_side_m > surface.widest_half_side_m()) {
      return invalid_tile("a patch is wider than the widest", tile.key);
    }
  }
  return {};
}

}  // namespace

TiledSurface::TiledSurface(const Surface& whole) {
  std::map<TileKey, std::vector<SurfacePatch>> by_tile;
  for (const SurfacePatch& patch : whole.patches) {
    by_tile[tile_of(patch.key, whole.cell_m, whole.tile_m)].push_back(patch);
  }
  TiledSurfaceWriter writer(whole.frame, whole.cell_m, whole.tile_m);
  for (auto& [key, patches] : by_tile) {
    std::ranges::sort(patches, {}, [&](const SurfacePatch& p) { return order_of(p, whole); });
    const Result<void> added = writer.add(key, patches);
    SIGHTLINE_CHECK(added.has_value());
  }
  *this = writer.take();
}

Result<void> TiledSurface::append(const PatchTile& tile, Surface& surface) const {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes,
                   patches_.read(tile.first * kEncodedPatch, tile.count * kEncodedPatch));
  ByteReader reader(bytes);
  const std::size_t before = surface.patches.size();
  surface.patches.resize(before + tile.count);
  for (SurfacePatch& patch : std::span(surface.patches).subspan(before)) decode(reader, patch);
  return {};
}

Result<Surface> TiledSurface::tile(const PatchTile& tile) const {
  Surface surface = empty();
  SIGHTLINE_TRY(append(tile, surface));
  return surface;
}

Result<Surface> TiledSurface::over(const Eigen::AlignedBox2d& box_m) const {
  Surface surface = empty();
  for (const PatchTile& tile : tiles_) {
    const Eigen::Vector2d low_m(tile.key.x * tile_m_, tile.key.y * tile_m_);
    const Eigen::AlignedBox2d of_tile_m(low_m, low_m + Eigen::Vector2d::Constant(tile_m_));
    if (box_m.intersects(of_tile_m)) SIGHTLINE_TRY(append(tile, surface));
  }
  return surface;
}

Result<Surface> TiledSurface::whole() const {
  Surface surface = empty();
  surface.patches.reserve(patch_count_);
  for (const PatchTile& tile : tiles_) SIGHTLINE_TRY(append(tile, surface));
  return surface;
}

TiledSurfaceWriter::TiledSurfaceWriter(const MapFrame& frame, double cell_m, double tile_m) {
  made_.frame_ = frame;
  made_.cell_m_ = cell_m;
  made_.tile_m_ = tile_m;
}

Result<void> TiledSurfaceWriter::add(const TileKey& key, std::span<const SurfacePatch> patches) {
  if (patches.empty()) return {};
  SIGHTLINE_CHECK(made_.tiles_.empty() || made_.tiles_.back().key < key);
  ByteWriter writer;
  writer.reserve(patches.size() * kEncodedPatch);
  for (const SurfacePatch& patch : patches) {
    encode(patch, writer);
    made_.widest_half_side_m_ = std::max(made_.widest_half_side_m_, patch.half_side_m);
  }
  made_.tiles_.push_back({key, made_.patch_count_, patches.size()});
  made_.patch_count_ += patches.size();
  return bytes_.append(writer.bytes());
}

TiledSurface TiledSurfaceWriter::take() {
  made_.patches_ = bytes_.take();
  return std::move(made_);
}

Result<void> validate(const TiledSurface& surface) {
  SIGHTLINE_TRY(validate(Surface{surface.frame(), surface.cell_m(), surface.tile_m(), {}}));
  for (std::size_t i = 0; i < surface.tiles().size(); ++i) {
    const PatchTile& tile = surface.tiles()[i];
    if (tile.count == 0) return invalid_tile("a tile without patches", tile.key);
    if (i > 0 && !(surface.tiles()[i - 1].key < tile.key)) {
      return invalid_tile("tiles must ascend", tile.key);
    }
    SIGHTLINE_TRY(validate_tile(surface, tile));
  }
  return {};
}

Table dump(const TiledSurface& surface) {
  const Result<Surface> whole = surface.whole();
  SIGHTLINE_CHECK(whole.has_value());
  return dump(*whole);
}

std::uint64_t payload_size(const TiledSurface& surface) {
  return head_of(surface).size() + surface.patches_.size();
}

Result<void> visit_payload(const TiledSurface& surface, const ByteSink& sink) {
  SIGHTLINE_TRY(sink(head_of(surface)));
  return surface.patches_.visit(sink);
}

Result<void> open_payload(const StoredBytes& payload, TiledSurface& surface) {
  const auto malformed = [](std::uint64_t byte) {
    return Error{ErrorCode::kBadLayer, "the payload of a surface cannot be decoded", "",
                 "payload byte " + std::to_string(byte)};
  };
  // The head of a surface without tiles.
  const std::uint64_t least = head_of(TiledSurface()).size();
  if (payload.size() < least) return malformed(payload.size());
  SIGHTLINE_ASSIGN(const std::vector<std::byte> fixed, payload.read(0, least));
  ByteReader reader(fixed);
  TiledSurface opened;
  decode(reader, opened.frame_);
  reader.get(opened.cell_m_);
  reader.get(opened.tile_m_);
  reader.get(opened.widest_half_side_m_);
  const auto tile_count = reader.get<std::uint64_t>();
  if (!reader.at_end() || tile_count > (payload.size() - least) / kEncodedTile) {
    return malformed(reader.offset());
  }
  SIGHTLINE_ASSIGN(const std::vector<std::byte> index,
                   payload.read(least, tile_count * kEncodedTile));
  ByteReader tiles(index);
  const std::uint64_t patches_begin = least + index.size();
  const std::uint64_t most_patches = (payload.size() - patches_begin) / kEncodedPatch;
  opened.tiles_.resize(tile_count);
  for (PatchTile& tile : opened.tiles_) {
    tiles.get(tile.key.x);
    tiles.get(tile.key.y);
    tiles.get(tile.count);
    tile.first = opened.patch_count_;
    if (tile.count > most_patches - opened.patch_count_) return malformed(least + tiles.offset());
    opened.patch_count_ += tile.count;
  }
  opened.patches_ = payload.part(patches_begin, payload.size() - patches_begin);
  if (opened.patches_.size() != opened.patch_count_ * kEncodedPatch) {
    return malformed(patches_begin + opened.patch_count_ * kEncodedPatch);
  }
  SIGHTLINE_TRY(validate(opened));
  surface = std::move(opened);
  return {};
}

}  // namespace sightline

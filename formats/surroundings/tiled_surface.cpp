#include "formats/surroundings/tiled_surface.h"

#include <algorithm>

namespace sightline {
namespace {

SurfacePatch decoded(std::span<const std::byte> row) {
  ByteReader reader(row);
  SurfacePatch patch;
  decode(reader, patch);
  return patch;
}

}  // namespace

Surface RowsOf<Surface>::head_of(const Surface& surface) { return part_of(surface, 0, 0); }

Surface RowsOf<Surface>::in_order(const Surface& whole) {
  Surface sorted = whole;
  std::ranges::sort(sorted.patches, {},
                    [&](const SurfacePatch& patch) { return order_of(patch, whole); });
  return sorted;
}

Surface RowsOf<Surface>::part_of(const Surface& head, std::size_t /*first*/,
                                 std::size_t /*count*/) {
  return {head.frame, head.cell_m, head.tile_m, {}};
}

void RowsOf<Surface>::encode_head(const Surface& surface, ByteWriter& writer) {
  sightline::encode(surface.frame, writer);
  writer.put(surface.cell_m);
  writer.put(surface.tile_m);
}

void RowsOf<Surface>::decode_head(ByteReader& reader, Surface& surface) {
  sightline::decode(reader, surface.frame);
  reader.get(surface.cell_m);
  reader.get(surface.tile_m);
}

void RowsOf<Surface>::encode(const Surface& surface, std::size_t first, std::size_t count,
                             ByteWriter& writer) {
  for (const SurfacePatch& patch : std::span(surface.patches).subspan(first, count)) {
    sightline::encode(patch, writer);
  }
}

void RowsOf<Surface>::decode(ByteReader& reader, Surface& surface, std::size_t first,
                             std::size_t count) {
  for (SurfacePatch& patch : std::span(surface.patches).subspan(first, count)) {
    sightline::decode(reader, patch);
  }
}

TileKey RowsOf<Surface>::tile(const Surface& head, std::span<const std::byte> row) {
  return tile_of(decoded(row).key, head.cell_m, head.tile_m);
}

double RowsOf<Surface>::reach_m(std::span<const std::byte> row) { return decoded(row).half_side_m; }

}  // namespace sightline

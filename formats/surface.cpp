#include "formats/surface.h"

#include <cmath>

namespace sightline {
namespace {

Error invalid(std::string message, std::string place) {
  return {ErrorCode::kInvalidArtifact, std::move(message), "", std::move(place)};
}

Result<void> validate_disc(const SurfaceDisc& disc, std::size_t index) {
  const bool is_unit = std::abs(disc.normal.squaredNorm() - 1.0) < 1e-9;
  if (!disc.centre_m.allFinite() || !is_unit) {
    return invalid("the centre is not finite or the normal not of unit length",
                   "disc " + std::to_string(index));
  }
  if (!(disc.radius_m > 0.0) || !std::isfinite(disc.radius_m)) {
    return invalid("the radius is not positive", "disc " + std::to_string(index));
  }
  return {};
}

std::pair<TileKey, CellKey> order_of(const SurfaceDisc& disc, const Surface& surface) {
  return {tile_of(disc.key, surface.cell_m, surface.tile_m), disc.key};
}

}  // namespace

Result<void> validate(const Surface& surface) {
  if (!is_tiling(surface.cell_m, surface.tile_m)) {
    return invalid("a tile is no multiple of a surface cell", "");
  }
  if (!surface.frame.origin_world_m.allFinite()) return invalid("the frame is not finite", "");
  for (std::size_t i = 0; i < surface.discs.size(); ++i) {
    const Result<void> valid = validate_disc(surface.discs[i], i);
    if (!valid) return valid.error();
    if (i > 0 && !(order_of(surface.discs[i - 1], surface) < order_of(surface.discs[i], surface))) {
      return invalid("discs must ascend by tile and key", "disc " + std::to_string(i));
    }
  }
  return {};
}

Table dump(const Surface& surface) {
  Table table;
  table.name = "surface";
  append_facts(surface.frame, table);
  table.facts.emplace_back("cell_m", surface.cell_m);
  table.facts.emplace_back("tile_m", surface.tile_m);
  table.columns = {"key_x",      "key_y",    "key_z",    "centre_x_m", "centre_y_m",
                   "centre_z_m", "normal_x", "normal_y", "normal_z",   "radius_m"};
  table.rows.reserve(surface.discs.size());
  for (const SurfaceDisc& disc : surface.discs) {
    std::vector<Cell> row = {std::int64_t{disc.key.x}, std::int64_t{disc.key.y},
                             std::int64_t{disc.key.z}};
    for (int i = 0; i < 3; ++i) row.emplace_back(disc.centre_m[i]);
    for (int i = 0; i < 3; ++i) row.emplace_back(disc.normal[i]);
    row.emplace_back(disc.radius_m);
    table.rows.push_back(std::move(row));
  }
  return table;
}

void encode(const Surface& surface, ByteWriter& writer) {
  encode(surface.frame, writer);
  writer.put(surface.cell_m);
  writer.put(surface.tile_m);
  writer.put<std::uint64_t>(surface.discs.size());
  for (const SurfaceDisc& disc : surface.discs) {
    writer.put(disc.key.x);
    writer.put(disc.key.y);
    writer.put(disc.key.z);
    for (int i = 0; i < 3; ++i) writer.put(disc.centre_m[i]);
    for (int i = 0; i < 3; ++i) writer.put(disc.normal[i]);
    writer.put(disc.radius_m);
  }
}

void decode(ByteReader& reader, Surface& surface) {
  constexpr std::size_t kDiscSize = 3 * sizeof(std::int32_t) + 7 * sizeof(double);
  decode(reader, surface.frame);
  reader.get(surface.cell_m);
  reader.get(surface.tile_m);
  surface.discs.resize(reader.get_count(kDiscSize));
  for (SurfaceDisc& disc : surface.discs) {
    reader.get(disc.key.x);
    reader.get(disc.key.y);
    reader.get(disc.key.z);
    for (int i = 0; i < 3; ++i) reader.get(disc.centre_m[i]);
    for (int i = 0; i < 3; ++i) reader.get(disc.normal[i]);
    reader.get(disc.radius_m);
  }
}

}  // namespace sightline

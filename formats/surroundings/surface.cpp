#include "formats/surroundings/surface.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace sightline {
namespace {

Result<void> validate_patch(const SurfacePatch& patch, std::size_t index) {
  const bool is_unit = std::abs(patch.normal.squaredNorm() - 1.0) < 1e-9;
  if (!patch.centre_m.allFinite() || !is_unit) {
    return invalid_artifact("the centre is not finite or the normal not of unit length",
                            concat("patch ", index));
  }
  if (!(patch.half_side_m > 0.0) || !std::isfinite(patch.half_side_m)) {
    return invalid_artifact("the side is not positive", concat("patch ", index));
  }
  if (patch.solid == 0) {
    return invalid_artifact("none of its squares is solid", concat("patch ", index));
  }
  return {};
}

// 16 digits, the highest square first.
std::string hexadecimal(std::uint64_t bits) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text(16, '0');
  for (auto digit = text.rbegin(); digit != text.rend(); ++digit, bits >>= 4) {
    *digit = kDigits[bits & 15];
  }
  return text;
}

SurfacePatch decoded(std::span<const std::byte> row) {
  ByteReader reader(row);
  SurfacePatch patch;
  decode(reader, patch);
  return patch;
}

}  // namespace

Eigen::Vector3d side_of(const SurfacePatch& patch) {
  constexpr double kSteepestGround = 0.9;  // height of its normal
  const bool is_ground = patch.normal.z() > kSteepestGround;
  const Eigen::Vector3d across(is_ground ? 1.0 : 0.0, 0.0, is_ground ? 0.0 : 1.0);
  return across.cross(patch.normal).normalized();
}

SurfaceOrder order_of(const SurfacePatch& patch, const Surface& surface) {
  return {tile_of(patch.key, surface.cell_m, surface.tile_m), patch.key, patch.half_side_m};
}

Result<void> validate(const Surface& surface) {
  if (!is_tiling(surface.cell_m, surface.tile_m)) {
    return invalid_artifact("a tile is not a multiple of a surface cell", "");
  }
  if (!surface.frame.origin_world_m.allFinite()) {
    return invalid_artifact("the frame is not finite", "");
  }
  for (std::size_t i = 0; i < surface.patches.size(); ++i) {
    SIGHTLINE_TRY(validate_patch(surface.patches[i], i));
    if (i > 0 &&
        !(order_of(surface.patches[i - 1], surface) < order_of(surface.patches[i], surface))) {
      return invalid_artifact("patches must ascend by tile, key and side", concat("patch ", i));
    }
  }
  return {};
}

Table dump(const Surface& surface) {
  Table table{"surface", {}, {}, {}};
  append_facts(surface.frame, table);
  table.facts.emplace_back("cell_m", surface.cell_m);
  table.facts.emplace_back("tile_m", surface.tile_m);
  table.columns = {"key_x",    "key_y",    "key_z",    "centre_x_m",  "centre_y_m", "centre_z_m",
                   "normal_x", "normal_y", "normal_z", "half_side_m", "solid"};
  table.rows.reserve(surface.patches.size());
  for (const SurfacePatch& patch : surface.patches) {
    std::vector<Cell> row = {std::int64_t{patch.key.x}, std::int64_t{patch.key.y},
                             std::int64_t{patch.key.z}};
    for (int i = 0; i < 3; ++i) row.emplace_back(patch.centre_m[i]);
    for (int i = 0; i < 3; ++i) row.emplace_back(patch.normal[i]);
    row.emplace_back(patch.half_side_m);
    row.emplace_back(hexadecimal(patch.solid));
    table.rows.push_back(std::move(row));
  }
  return table;
}

Surface RowsOf<Surface>::in_order(const Surface& whole) {
  Surface sorted = whole;
  std::ranges::sort(sorted.patches, {},
                    [&](const SurfacePatch& patch) { return order_of(patch, whole); });
  return sorted;
}

TileKey RowsOf<Surface>::tile(const Surface& head, std::span<const std::byte> row) {
  return tile_of(decoded(row).key, head.cell_m, head.tile_m);
}

double RowsOf<Surface>::reach_m(std::span<const std::byte> row) { return decoded(row).half_side_m; }

}  // namespace sightline

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "formats/artifact.h"
#include "formats/geometry.h"
#include "formats/record/fields.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/tables/stored_table.h"

namespace sightline {

// A patch is cut into so many squares along each side, each of them solid or open.
inline constexpr int kPatchSquares = 8;

// A small square of something solid, or of which a part is; rays hit it from both sides.
struct SurfacePatch {
  CellKey key;  // of the cell that holds the centre
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit length, z >= 0
  double half_side_m = 0.0;
  std::uint64_t solid = ~std::uint64_t{0};  // bit of square_at(): a ray is stopped there
};
SIGHTLINE_FIELDS(SurfacePatch, key, centre_m, normal, half_side_m, solid)

// The number of the square at a place of the patch, in halves of its sides from its centre
// along side_of() and normal x side_of(): rows along the first. Each within [-1, 1].
inline int square_at(double along, double across) {
  const auto place = [](double of_half) {
    const int square = static_cast<int>((of_half + 1.0) * (0.5 * kPatchSquares));
    return square < kPatchSquares ? square : kPatchSquares - 1;
  };
  return kPatchSquares * place(across) + place(along);
}

// Unit vector along one pair of sides; the other pair is at right angles to it and to the normal.
// Level where the patch is steep; on ground the sides run along the map's axes.
Eigen::Vector3d side_of(const SurfacePatch& patch);

// Calls use(middle in the map frame) for each solid square of the patch, cut into parts x parts.
template <class Use>
void visit_solid_squares(const SurfacePatch& patch, int parts, const Use& use) {
  const Eigen::Vector3d along = side_of(patch);
  const Eigen::Vector3d across = patch.normal.cross(along);
  const int count = parts * kPatchSquares;
  const double half_part_m = patch.half_side_m / count;
  for (int row = 0; row < count; ++row) {
    for (int column = 0; column < count; ++column) {
      const int square = kPatchSquares * (row / parts) + column / parts;
      if ((patch.solid >> square & 1U) == 0) continue;
      const Eigen::Vector3d middle_m =
          patch.centre_m +
          half_part_m * ((2 * column + 1 - count) * along + (2 * row + 1 - count) * across);
      use(middle_m);
    }
  }
}

// What rays can hit: patches on the cells of a grid finer than the NDT map's. All of it or what
// lies in some tiles.
struct Surface {
  MapFrame frame;
  double cell_m = 0.0;
  double tile_m = 0.0;
  std::vector<SurfacePatch> patches;  // ascending by order_of()
};
SIGHTLINE_FIELDS(Surface, frame, cell_m, tile_m, patches)

// By tile, then cell, then half side: no two patches have the same.
using SurfaceOrder = std::tuple<TileKey, CellKey, double>;
SurfaceOrder order_of(const SurfacePatch& patch, const Surface& surface);

// As an artifact: TiledSurface.
Result<void> validate(const Surface& surface);
Table dump(const Surface& surface);

// One patch takes so many bytes.
inline constexpr std::size_t kEncodedPatch =
    3 * sizeof(std::int32_t) + 7 * sizeof(double) + sizeof(std::uint64_t);

// A row is a patch.
template <>
struct RowsOf<Surface> : RowsInVector<Surface, SurfacePatch, &Surface::patches> {
  static std::size_t size(const Surface& /*head*/) { return kEncodedPatch; }
  static Surface head_of(const Surface& surface) { return part_of(surface, 0, 0); }
  static Surface part_of(const Surface& head, std::size_t /*first*/, std::size_t /*count*/) {
    return {head.frame, head.cell_m, head.tile_m, {}};
  }
  // Patches of a whole surface may have any order.
  static Surface in_order(const Surface& whole);
  static TileKey tile(const Surface& head, std::span<const std::byte> row);
  // Half the side of the patch.
  static double reach_m(std::span<const std::byte> row);
};

// The patches of a surface, tile by tile.
using TiledSurface = StoredTable<Surface>;

// A surface is an artifact in this form alone.
SIGHTLINE_ARTIFACT(TiledSurface, "surface", 5)

}  // namespace sightline

#include "passes/map/build_nd_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/tables/stored_table_writer.h"

namespace sightline {
namespace {

constexpr double kLeastHalfSide_m = 0.05;  // an ND of less is one square

// Half the extent along axis `i` of points that lie evenly and have the ND's variance there.
double half_extent_m(const Nd& nd, Eigen::Index i) {
  return std::numbers::sqrt3 * std::sqrt(nd.eigenvalues_m2[i]);
}

// A square is solid where the nearest of its places to the centre is within the extent: a pole
// narrower than a square keeps those around it.
bool is_solid(const Nd& nd, const Eigen::Vector3d& from_centre_m, double half_square_m) {
  for (const Eigen::Index axis : {0, 1}) {
    const double off_m = std::abs(nd.eigenvectors.col(axis).dot(from_centre_m));
    if (off_m > half_extent_m(nd, axis) + 0.5 * half_square_m) return false;
  }
  return true;
}

std::uint64_t solid_squares(const Nd& nd, const SurfacePatch& patch) {
  const bool has_gaps = dimension_class(nd) == 3;
  const Eigen::Vector3d along = side_of(patch);
  const Eigen::Vector3d across = patch.normal.cross(along);
  const double half_square_m = patch.half_side_m / kPatchSquares;
  std::uint64_t solid = 0;
  for (int row = 0; row < kPatchSquares; ++row) {
    for (int column = 0; column < kPatchSquares; ++column) {
      if (has_gaps && (row + column) % 2 == 1) continue;
      const Eigen::Vector3d from_centre_m =
          half_square_m *
          ((2 * column + 1 - kPatchSquares) * along + (2 * row + 1 - kPatchSquares) * across);
      if (!is_solid(nd, from_centre_m, half_square_m)) continue;
      solid |= std::uint64_t{1} << (kPatchSquares * row + column);
    }
  }
  return solid;
}

}  // namespace

Result<TiledSurface> build_nd_surface(PassContext& ctx, const NoOptions& /*options*/,
                                      const NdtMap& map) {
  const Surface surface = surface_of_nds(map);
  if (surface.patches.empty()) {
    return Error{ErrorCode::kEmptyMap, "the map has no valid cell that rays could hit", "",
                 "pass build-nd-surface"};
  }
  ctx.warn(
      concat("a map file contains no surface: rays are cast on flat patches, one for each of its ",
             map.nds.size(),
             " NDs. These are coarser than the original points, and so are occupancy_ratio, "
             "virtual scans and simulated errors. Annotate the points if you still have them"));
  StoredTableWriter<Surface> writer(surface);
  SIGHTLINE_TRY(writer.append(surface));
  return writer.take();
}

Surface surface_of_nds(const NdtMap& map) {
  Surface surface;
  surface.frame = map.frame;
  surface.cell_m = map.cell_m;
  surface.tile_m = map.tile_m;
  for (const Nd& nd : map.nds) {
    SurfacePatch patch;
    patch.key = nd.key;
    patch.centre_m = nd.mean_m;
    patch.normal = nd.eigenvectors.col(2).normalized();
    if (patch.normal.z() < 0.0) patch.normal = -patch.normal;
    patch.half_side_m = std::max(kLeastHalfSide_m, half_extent_m(nd, 0));
    patch.solid = solid_squares(nd, patch);
    if (patch.solid != 0) surface.patches.push_back(patch);
  }
  return surface;
}

}  // namespace sightline

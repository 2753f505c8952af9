#include "passes/build_surface.h"

#include <algorithm>
#include <cmath>

#include "passes/build_ndt.h"

namespace sightline {
namespace {

// Points spread evenly over a square have a standard deviation of edge / sqrt(12) along it, and
// half a diagonal of edge / sqrt(2): sqrt(6) standard deviations reach the square's corners.
constexpr double kRadiusPerSigma = 2.45;
// A disc narrower than this lets rays pass between samples of one scan line.
constexpr double kLeastRadiusPerCell = 0.3;
// Half the diagonal of a face: wider discs only overlap their neighbours.
constexpr double kMostRadiusPerCell = 0.71;

SurfaceDisc disc_of(const Nd& nd, double cell_m) {
  SurfaceDisc disc;
  disc.key = nd.key;
  disc.centre_m = nd.mean_m;
  disc.normal = nd.eigenvectors.col(2);
  if (disc.normal.z() < 0.0) disc.normal = -disc.normal;
  disc.radius_m = std::clamp(kRadiusPerSigma * std::sqrt(nd.eigenvalues_m2[0]),
                             kLeastRadiusPerCell * cell_m, kMostRadiusPerCell * cell_m);
  return disc;
}

}  // namespace

std::vector<OptionField> option_fields(BuildSurfaceOptions& options) {
  return {
      number("cell_m", options.cell_m, "edge of a surface cell, m", 0.05, 10.0),
      number("tile_m", options.tile_m, "edge of a tile, a multiple of the cell, m", 1.0, 10000.0),
      integer("min_points", options.min_points, "points that a disc needs", 3, 1000000)};
}

Result<Surface> build_surface(PassContext& ctx, const BuildSurfaceOptions& options,
                              const SurfacePoints& points) {
  const Result<NdtMap> cells =
      build_ndt(ctx, {options.cell_m, options.tile_m, options.min_points}, points);
  if (!cells) return cells.error();
  Surface surface;
  surface.frame = cells->frame;
  surface.cell_m = cells->cell_m;
  surface.tile_m = cells->tile_m;
  surface.discs.reserve(cells->nds.size());
  for (const Nd& nd : cells->nds) surface.discs.push_back(disc_of(nd, cells->cell_m));
  return surface;
}

}  // namespace sightline

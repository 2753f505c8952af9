#include "passes/build_surface.h"

#include <algorithm>
#include <cmath>

#include "passes/build_ndt.h"

namespace sightline {
namespace {

// Chosen against the exact triangles of generated towns (16 beams, a scan a metre, poses off by
// 2 cm): of the cells and radii tried, these agree best with what a ray truly hits without making
// walls thicker than they are. Geometric means of the two spreads keep poles and edges narrow.
constexpr double kRadiusPerSigma = 2.8;
// A disc narrower than this lets rays pass between samples of one scan line.
constexpr double kLeastRadiusPerCell = 0.2;
// A little over half the diagonal of a face: wider discs only shade what lies behind their edges.
constexpr double kMostRadiusPerCell = 0.8;

SurfaceDisc disc_of(const Nd& nd, double cell_m) {
  const Eigen::Vector3d sigma_m = nd.eigenvalues_m2.cwiseSqrt();
  SurfaceDisc disc;
  disc.key = nd.key;
  disc.centre_m = nd.mean_m;
  disc.normal = nd.eigenvectors.col(2);
  if (disc.normal.z() < 0.0) disc.normal = -disc.normal;
  disc.radius_m = std::clamp(kRadiusPerSigma * std::sqrt(sigma_m[0] * sigma_m[1]),
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
  if (!cells) {
    Error error = cells.error();
    error.place = "pass build-surface";
    return error;
  }
  Surface surface;
  surface.frame = cells->frame;
  surface.cell_m = cells->cell_m;
  surface.tile_m = cells->tile_m;
  surface.discs.reserve(cells->nds.size());
  for (const Nd& nd : cells->nds) surface.discs.push_back(disc_of(nd, cells->cell_m));
  return surface;
}

}  // namespace sightline

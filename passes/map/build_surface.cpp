#include "passes/map/build_surface.h"

#include <algorithm>
#include <cmath>

#include "passes/map/build_ndt.h"

namespace sightline {
namespace {

// Chosen against the exact triangles of generated towns (16 beams, a scan a metre, poses off by
// 2 cm): of the shapes, cells and sizes tried (tests/bench/surface_bench), these agree best with
// what a ray truly hits without making walls thicker than they are. Discs of the same area agree
// as well but cost half as much again a ray, because Embree puts a cube around each. The geometric
// mean of the two spreads keeps poles and edges narrow.
constexpr double kHalfSidePerSigma = 2.5;
// A patch narrower than this lets rays pass between samples of one scan line.
constexpr double kLeastHalfSidePerCell = 0.18;
// Wider patches only shade what lies behind their edges.
constexpr double kMostHalfSidePerCell = 0.7;

SurfacePatch patch_of(const Nd& nd, double cell_m) {
  const Eigen::Vector3d sigma_m = nd.eigenvalues_m2.cwiseSqrt();
  SurfacePatch patch;
  patch.key = nd.key;
  patch.centre_m = nd.mean_m;
  patch.normal = nd.eigenvectors.col(2);
  if (patch.normal.z() < 0.0) patch.normal = -patch.normal;
  patch.half_side_m = std::clamp(kHalfSidePerSigma * std::sqrt(sigma_m[0] * sigma_m[1]),
                                 kLeastHalfSidePerCell * cell_m, kMostHalfSidePerCell * cell_m);
  return patch;
}

}  // namespace

std::vector<OptionField> option_fields(BuildSurfaceOptions& options) {
  return {number("cell_m", options.cell_m, "edge of a surface cell, m", 0.05, 10.0),
          shared(number("tile_m", options.tile_m, "edge of a tile, a multiple of the cell, m", 1.0,
                        10000.0)),
          integer("min_points", options.min_points, "points that a patch needs", 3, 1000000)};
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
  surface.patches.reserve(cells->nds.size());
  for (const Nd& nd : cells->nds) surface.patches.push_back(patch_of(nd, cells->cell_m));
  return surface;
}

}  // namespace sightline

#include "passes/map/build_surface.h"

#include <algorithm>

#include "formats/base/parallel.h"
#include "passes/map/build_ndt.h"
#include "passes/map/surface/ground_gaps.h"
#include "passes/map/surface/patch_evidence.h"
#include "passes/map/surface/surface_candidates.h"

// Points alone do not say where a surface ends: between two of them it may go on, or have a hole
// that rays go through. So each patch is laid through the points of a cell and cut into squares,
// and of each square it is counted how many returns lie there and how many rays went through it and
// on. Rays decide where there were any; elsewhere a patch is solid between its returns, which the
// scan lines leave apart, and nowhere beyond them.

namespace sightline {
namespace {

// A part of surface points as rays. Errors: what reading a scan says.
Result<SeenScan> read_part(const SurfacePoints& points, const SurfacePointReader& reader,
                           std::size_t part) {
  SeenScan scan;
  SIGHTLINE_ASSIGN(scan.points_m, reader.standing(part));
  scan.has_origin = part < points.scans.size() && points.store->has_origins();
  if (scan.has_origin) scan.origin_m = points.scans[part].T_map_lidar.translation();
  return scan;
}

// A few scans in memory at a time. Errors: what reading a scan says.
Result<void> look_at_scans(PassContext& ctx, const SurfacePoints& points, PatchEvidence& evidence) {
  constexpr std::size_t kScansAtOnce = 16;
  const SurfacePointReader reader(points);
  for (std::size_t first = 0; first < reader.part_count(); first += kScansAtOnce) {
    const std::size_t count = std::min(kScansAtOnce, reader.part_count() - first);
    std::vector<Result<SeenScan>> read(count, SeenScan{});
    parallel_for(count, ctx.threads,
                 [&](std::size_t i) { read[i] = read_part(points, reader, first + i); });
    std::vector<SeenScan> scans;
    for (Result<SeenScan>& scan : read) {
      if (!scan) return scan.error();
      scans.push_back(std::move(*scan));
    }
    evidence.add(scans, ctx.threads);
    ctx.progress(first + count, reader.part_count());
  }
  return {};
}

// Errors: what reading a scan says.
Result<std::vector<SurfacePatch>> patches_of(PassContext& ctx, const NdtMap& cells, int min_points,
                                             const SurfacePoints& points) {
  const std::vector<SurfaceCandidate> candidates =
      surface_candidates(cells, static_cast<std::uint32_t>(min_points));
  std::vector<SurfacePatch> patches;
  patches.reserve(candidates.size());
  for (const SurfaceCandidate& candidate : candidates) patches.push_back(candidate.patch);
  const PatchGrid grid(patches, cells.cell_m);
  PatchEvidence evidence(grid, patches.size());
  SIGHTLINE_TRY(look_at_scans(ctx, points, evidence));
  patches = solid_patches(candidates, grid, evidence);
  const std::vector<SurfacePatch> between = ground_between(patches, cells.cell_m);
  patches.insert(patches.end(), between.begin(), between.end());
  return patches;
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
  // Cells of two points take part in longer ones.
  Result<NdtMap> cells = build_ndt(ctx, {options.cell_m, options.tile_m, 2}, points);
  if (!cells) {
    Error error = cells.error();
    error.place = "pass build-surface";
    return error;
  }
  Surface surface;
  surface.frame = cells->frame;
  surface.cell_m = cells->cell_m;
  surface.tile_m = cells->tile_m;
  SIGHTLINE_ASSIGN(surface.patches, patches_of(ctx, *cells, options.min_points, points));
  if (surface.patches.empty()) {
    return Error{ErrorCode::kEmptyMap,
                 "no cell of " + std::to_string(cells->nds.size()) + " holds " +
                     std::to_string(options.min_points) + " points that rays do not pass through",
                 "", "pass build-surface"};
  }
  std::ranges::sort(surface.patches, [&](const SurfacePatch& a, const SurfacePatch& b) {
    return order_of(a, surface) < order_of(b, surface);
  });
  return surface;
}

}  // namespace sightline

#include "passes/ingest/ingest_map.h"

#include <limits>

#include "formats/text/numbers.h"
#include "passes/ingest/check_map_axes.h"

namespace sightline {
namespace {

// Of a grid of cells, from its origin.
constexpr double kWidest_m = 1e8;

Result<Eigen::AlignedBox3d> box_of(const PointMap& map) {
  Eigen::AlignedBox3d box_m;
  for (const PointMapFile& file : map.files) box_m.extend(file.box_m);
  if (box_m.sizes().maxCoeff() <= kWidest_m) return box_m;
  return Error{ErrorCode::kInvalidArtifact,
               concat("map ", map.name, " is wider than ", format_double(kWidest_m), " m"), "",
               "pass ingest-map"};
}

// Squares of 1 m that hold points stand for the surface: a plane through them fills about as many.
constexpr double kSquare_m = 1.0;

Result<double> points_per_m2(PassContext& ctx, const SurfacePoints& points) {
  CellIndex squares;
  const SurfacePointReader reader(points);
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> standing_m, reader.standing(part));
    for (const Eigen::Vector3d& point_m : standing_m) squares.add(cell_key(point_m, kSquare_m));
    ctx.progress(part + 1, reader.part_count());
  }
  const double surface_m2 = static_cast<double>(squares.size()) * kSquare_m * kSquare_m;
  return static_cast<double>(points.standing_count) / surface_m2;
}

void warn_of_density(const PassContext& ctx, const PointMap& map, double density) {
  if (density >= kDenseForSurface) return;
  const bool is_too_thin = density < kDenseForNds;
  ctx.warn(
      concat("map ", map.name, " has ", fixed(density, 1), " points per square metre of surface: ",
             (is_too_thin ? "most cells of 2 m have fewer than the 10 points that an ND needs (" +
                                fixed(kDenseForNds, 1) + ") and are left out; "
                          : ""),
             "below ", fixed(kDenseForSurface, 1),
             " the simulated surface has gaps, and simulated scans miss returns. Export the map "
             "with more points"));
}

void warn_of_files(const PassContext& ctx, const PointMap& map) {
  for (const std::string& warning : map.warnings) ctx.warn(concat("map ", map.name, ": ", warning));
  std::uint64_t dropped = 0;
  for (const PointMapFile& file : map.files) dropped += file.dropped_count;
  if (dropped == 0) return;
  ctx.warn(concat("map ", map.name, ": ", dropped,
                  " points are not finite, at (0,0,0) or withheld, and were left out"));
}

}  // namespace

std::vector<OptionField> option_fields(IngestMapOptions& options) {
  return {
      shared(number("tile_m", options.tile_m,
                    "edge length of a map tile, m; the origin of the map frame is a multiple of it",
                    1.0, 10000.0))};
}

Result<SurfacePoints> ingest_map(PassContext& ctx, const IngestMapOptions& options,
                                 const PointMap& map) {
  SIGHTLINE_ASSIGN(const Eigen::AlignedBox3d box_m, box_of(map));
  SurfacePoints points;
  points.frame = frame_near(box_m.min(), options.tile_m);
  for (std::uint32_t i = 0; i < map.files.size(); ++i) {
    PlacedScan piece;
    piece.index = i;
    piece.T_map_lidar.translation() = -points.frame.origin_world_m;
    piece.max_range_m = std::numeric_limits<double>::infinity();
    points.scans.push_back(piece);
    points.standing_count += map.files[i].point_count;
  }
  points.store = point_map_store(map);
  SIGHTLINE_TRY(check_map_axes(points));
  warn_of_files(ctx, map);
  SIGHTLINE_ASSIGN(const double density, points_per_m2(ctx, points));
  warn_of_density(ctx, map, density);
  return points;
}

void reattach(SurfacePoints& points, const PointMap& map) { points.store = point_map_store(map); }

Result<NdtMap> ingest_compiled_map(PassContext& /*ctx*/, const NoOptions& /*options*/,
                                   const CompiledMap& map) {
  return map.ndt;
}

}  // namespace sightline

#include "passes/ingest/ingest_nd_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace sightline {
namespace {

constexpr const char* kPlace = "pass ingest-nd-map";
constexpr double kLeastExtent_m2 = 1e-6;  // "NDT map", v1
constexpr double kWidest_cells = 0x1.0p29;

// Lowest corner of all cells, in the world.
Eigen::Vector3d lowest_corner_m(const ForeignNds& map) {
  Eigen::Vector3d lowest_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  for (const ForeignNd& nd : map.nds) {
    const Eigen::Vector3d corner(nd.key_world.x, nd.key_world.y, nd.key_world.z);
    lowest_m = lowest_m.cwiseMin(map.cell_m * corner);
  }
  return lowest_m;
}

// The mean in the map frame; rounding must not carry it over an upper face.
Eigen::Vector3d mean_of(const ForeignNd& nd, const CellKey& key, double cell_m) {
  Eigen::Vector3d mean_m = cell_m * Eigen::Vector3d(key.x, key.y, key.z) + nd.mean_in_cell_m;
  const CellKey found = cell_key(mean_m, cell_m);
  const std::int32_t off[] = {found.x - key.x, found.y - key.y, found.z - key.z};
  for (int axis = 0; axis < 3; ++axis) {
    if (off[axis] == 0) continue;
    constexpr double kFar_m = std::numeric_limits<double>::infinity();
    mean_m[axis] = std::nextafter(mean_m[axis], off[axis] > 0 ? -kFar_m : kFar_m);
  }
  return mean_m;
}

std::vector<Nd> valid_nds(const ForeignNds& map, const CellKey& origin, int min_points,
                          NdtMap& counts) {
  std::vector<Nd> nds;
  for (const ForeignNd& foreign : map.nds) {
    if (foreign.point_count < static_cast<std::uint32_t>(std::max(min_points, 2))) {
      ++counts.sparse_cell_count;
      continue;
    }
    Nd nd;
    nd.key = {foreign.key_world.x - origin.x, foreign.key_world.y - origin.y,
              foreign.key_world.z - origin.z};
    nd.point_count = foreign.point_count;
    nd.mean_m = mean_of(foreign, nd.key, map.cell_m);
    nd.covariance_m2 = foreign.covariance_m2;
    decompose(nd);
    if (nd.eigenvalues_m2[0] < kLeastExtent_m2) {
      ++counts.degenerate_cell_count;
      continue;
    }
    nds.push_back(nd);
  }
  return nds;
}

void warn(const PassContext& ctx, const ForeignNds& map, const NdtMap& ndt, int min_points) {
  for (const std::string& warning : map.warnings) ctx.warn(concat("map ", map.name, ": ", warning));
  const std::uint64_t all = ndt.nds.size() + ndt.sparse_cell_count + ndt.degenerate_cell_count;
  ctx.inform(
      fmt::format("map {} contains NDs and no points: {} of its {} cells of {} m are used; {} have "
                  "fewer than {} points, {} no extent",
                  map.name, ndt.nds.size(), all, format_double(map.cell_m), ndt.sparse_cell_count,
                  min_points, ndt.degenerate_cell_count));
}

}  // namespace

std::vector<OptionField> option_fields(IngestNdMapOptions& options) {
  return {
      shared(number("tile_m", options.tile_m,
                    "edge length of a map tile, m; the origin of the map frame is a multiple of it",
                    1.0, 10000.0)),
      integer("min_points", options.min_points,
              "least points of a cell, for maps that contain cells instead of points", 2, 100000)};
}

Result<NdtMap> ingest_nd_map(PassContext& ctx, const IngestNdMapOptions& options,
                             const ForeignNds& map) {
  if (!is_tiling(map.cell_m, options.tile_m)) {
    return Error{
        ErrorCode::kBadValue,
        concat("annotation.tile_m: found ", format_double(options.tile_m),
               " m, expected a multiple of the map's cell of ", format_double(map.cell_m), " m"),
        "", kPlace};
  }
  const Error is_empty{
      ErrorCode::kEmptyMap,
      concat("map ", map.name, " has no cell of ", options.min_points, " points or more"), "",
      kPlace};
  if (map.nds.empty()) return is_empty;
  NdtMap ndt;
  ndt.frame = frame_near(lowest_corner_m(map), options.tile_m);
  ndt.cell_m = map.cell_m;
  ndt.tile_m = options.tile_m;
  ndt.point_count = map.point_count;
  ndt.sparse_cell_count = map.single_point_count;
  const Eigen::Vector3d origin_cells = ndt.frame.origin_world_m / map.cell_m;
  if (origin_cells.cwiseAbs().maxCoeff() > kWidest_cells) {
    return Error{ErrorCode::kInvalidArtifact,
                 concat("map ", map.name, " is too wide for the grid of its cells"), "", kPlace};
  }
  const CellKey origin{static_cast<std::int32_t>(std::llround(origin_cells.x())),
                       static_cast<std::int32_t>(std::llround(origin_cells.y())),
                       static_cast<std::int32_t>(std::llround(origin_cells.z()))};
  ndt.nds = valid_nds(map, origin, options.min_points, ndt);
  if (ndt.nds.empty()) return is_empty;
  std::ranges::sort(ndt.nds, [&](const Nd& a, const Nd& b) {
    const TileKey of_a = tile_of(a.key, ndt.cell_m, ndt.tile_m);
    const TileKey of_b = tile_of(b.key, ndt.cell_m, ndt.tile_m);
    return of_a != of_b ? of_a < of_b : a.key < b.key;
  });
  warn(ctx, map, ndt, options.min_points);
  return ndt;
}

}  // namespace sightline

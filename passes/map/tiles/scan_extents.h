#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/grid/cell_key.h"
#include "formats/surroundings/surface_points.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// What is known of one part of surface points (SurfacePointReader) without its points. It covers
// all points within range, both standing and moving: a further drive can change which points count
// as moving, but the extents of earlier scans stay the same.
struct ScanExtent {
  std::uint64_t point_count = 0;
  Eigen::Vector2d low_m = Eigen::Vector2d::Zero();  // box of the points, map frame
  Eigen::Vector2d high_m = Eigen::Vector2d::Zero();
  std::vector<TileKey> blocks;  // that hold one of them, ascending
};
SIGHTLINE_FIELDS(ScanExtent, point_count, low_m, high_m, blocks)

// Square columns of whole cells, the unit of extents.
struct BlockGrid {
  double cell_m = 0.0;
  std::int32_t block_cells = 1;
};

// Of each part, in their order: so that a pass can go tile by tile and reads only the scans that
// reach a tile. These are the first parts of the work of `pass`; for what it does next see
// after_extents(). Errors: what reading says; invalid-artifact (a point that is not finite or lies
// more than 2^30 cells from the origin).
Result<std::vector<ScanExtent>> measure_extents(const PassContext& ctx, const SurfacePoints& points,
                                                const BlockGrid& grid, const std::string& pass);

// The context for the later parts of the same pass. Their numbers begin after those that
// measure_extents() used, so that each number is used once.
PassContext after_extents(const PassContext& ctx, const SurfacePoints& points);

}  // namespace sightline

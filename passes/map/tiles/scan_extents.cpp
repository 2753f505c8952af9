#include "passes/map/tiles/scan_extents.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "formats/base/bytes.h"
#include "passes/pass/work_in_parts.h"

namespace sightline {
namespace {

constexpr std::size_t kScansInBlock = 32;

struct Extents {
  std::vector<ScanExtent> of_parts;
  std::uint64_t outside = kNone;  // position of the first point that the grid cannot hold
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
};

bool is_held(const Eigen::Vector3d& point_m, double reach_m) {
  return std::abs(point_m.x()) < reach_m && std::abs(point_m.y()) < reach_m &&
         std::abs(point_m.z()) < reach_m;
}

// Adds a part; positions of points count from the first part of the work.
void add(std::span<const Eigen::Vector3d> points_m, const BlockGrid& grid, std::uint64_t before,
         Extents& extents) {
  const double reach_m = 0x1.0p30 * grid.cell_m;
  ScanExtent extent;
  extent.standing_count = points_m.size();
  if (!points_m.empty()) extent.low_m = extent.high_m = points_m.front().head<2>();
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (!is_held(points_m[i], reach_m)) {
      extents.outside = std::min(extents.outside, before + i);
      break;
    }
    extent.low_m = extent.low_m.cwiseMin(points_m[i].head<2>());
    extent.high_m = extent.high_m.cwiseMax(points_m[i].head<2>());
    const TileKey cell = tile_key(points_m[i], grid.cell_m);
    const TileKey block{floor_divide(cell.x, grid.block_cells),
                        floor_divide(cell.y, grid.block_cells)};
    if (extent.blocks.empty() || extent.blocks.back() != block) extent.blocks.push_back(block);
  }
  std::ranges::sort(extent.blocks);
  extent.blocks.erase(std::unique(extent.blocks.begin(), extent.blocks.end()), extent.blocks.end());
  extents.of_parts.push_back(std::move(extent));
}

std::vector<std::byte> to_bytes(const Extents& extents) {
  ByteWriter writer;
  writer.put(extents.outside);
  for (const ScanExtent& extent : extents.of_parts) {
    writer.put(extent.standing_count);
    for (int axis = 0; axis < 2; ++axis) writer.put(extent.low_m[axis]);
    for (int axis = 0; axis < 2; ++axis) writer.put(extent.high_m[axis]);
    writer.put_array(extent.blocks);
  }
  return writer.take();
}

// False where these are not the extents of so many parts.
bool from_bytes(std::span<const std::byte> bytes, std::span<ScanExtent> extents,
                std::uint64_t& outside) {
  ByteReader reader(bytes);
  reader.get(outside);
  for (ScanExtent& extent : extents) {
    reader.get(extent.standing_count);
    for (int axis = 0; axis < 2; ++axis) reader.get(extent.low_m[axis]);
    for (int axis = 0; axis < 2; ++axis) reader.get(extent.high_m[axis]);
    reader.get_array(extent.blocks);
  }
  return reader.at_end();
}

// Parts of surface points, in the order of SurfacePointReader.
std::size_t part_count_of(const SurfacePoints& points) {
  return points.scans.size() + (points.points_m.empty() ? 0 : 1);
}

std::size_t block_count(const SurfacePoints& points) {
  return (part_count_of(points) + kScansInBlock - 1) / kScansInBlock;
}

std::vector<std::size_t> parts_of_block(const SurfacePoints& points, std::size_t block) {
  std::vector<std::size_t> parts;
  const std::size_t end = std::min(part_count_of(points), (block + 1) * kScansInBlock);
  for (std::size_t part = block * kScansInBlock; part < end; ++part) parts.push_back(part);
  return parts;
}

Result<Extents> extents_of(const SurfacePoints& points, const BlockGrid& grid, std::size_t block) {
  const std::vector<std::size_t> parts = parts_of_block(points, block);
  const SurfacePointReader reader(points, parts);
  Extents found;
  std::uint64_t before = 0;
  for (const std::size_t part : parts) {
    SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> points_m, reader.standing(part));
    add(points_m, grid, before, found);
    before += points_m.size();
  }
  return found;
}

std::optional<Digest> content_of_block(const SurfacePoints& points, std::size_t block) {
  ByteWriter writer;
  writer.put_string("extents");
  return content_of_parts(points, parts_of_block(points, block), std::move(writer));
}

}  // namespace

Result<std::vector<ScanExtent>> measure_extents(const PassContext& ctx, const SurfacePoints& points,
                                                const BlockGrid& grid, const std::string& pass) {
  std::vector<ScanExtent> extents(part_count_of(points));
  std::vector<std::uint64_t> outside(block_count(points), Extents::kNone);
  PartedWork work;
  work.count = outside.size();
  work.content = [&](std::size_t block) { return content_of_block(points, block); };
  work.make = [&](std::size_t block) -> Result<std::vector<std::byte>> {
    SIGHTLINE_ASSIGN(const Extents found, extents_of(points, grid, block));
    return to_bytes(found);
  };
  work.take = [&](std::size_t block, std::span<const std::byte> bytes) {
    const std::size_t first = block * kScansInBlock;
    const std::size_t count = std::min(kScansInBlock, extents.size() - first);
    return from_bytes(bytes, std::span(extents).subspan(first, count), outside[block]);
  };
  SIGHTLINE_TRY(work_in_parts(ctx, work, ctx.threads));
  std::uint64_t before = 0;
  for (std::size_t block = 0; block < outside.size(); ++block) {
    if (outside[block] != Extents::kNone) {
      return Error{ErrorCode::kInvalidArtifact,
                   "surface point " + std::to_string(before + outside[block]) +
                       " is not finite or lies more than 2^30 cells from the origin",
                   "", "pass " + pass};
    }
    for (const std::size_t part : parts_of_block(points, block)) {
      before += extents[part].standing_count;
    }
  }
  return extents;
}

PassContext after_extents(const PassContext& ctx, const SurfacePoints& points) {
  const auto later = [first = block_count(points)](const PartName& part) {
    return PartName{first + part.number, part.content};
  };
  PassContext after = ctx;
  if (ctx.saved_part) {
    after.saved_part = [&ctx, later](const PartName& part) { return ctx.saved_part(later(part)); };
  }
  if (ctx.part_sink) {
    after.part_sink = [&ctx, later](const PartName& part, std::span<const std::byte> bytes) {
      ctx.part_sink(later(part), bytes);
    };
  }
  if (ctx.parts_sink) {
    after.parts_sink = [&ctx, &points, later](std::span<const PartName> parts) {
      std::vector<PartName> told;
      for (std::size_t block = 0; block < block_count(points); ++block) {
        told.push_back({block, content_of_block(points, block)});
      }
      for (const PartName& part : parts) told.push_back(later(part));
      ctx.parts_sink(told);
    };
  }
  return after;
}

}  // namespace sightline

#include "passes/map/tiles/cell_tiles.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/parallel.h"
#include "passes/pass/work_in_parts.h"

namespace sightline {
namespace {

// Sensors see 100 m around: smaller ones would open each scan more often, larger ones take more
// memory (a street of 16 beams about 0.4 MiB for each of its metres in the tile).
constexpr double kLeastTile_m = 256.0;
constexpr std::int32_t kBlocks = 8;  // along the edge of a tile

TileKey divided(const TileKey& key, std::int32_t divisor) {
  return {floor_divide(key.x, divisor), floor_divide(key.y, divisor)};
}

// The frame begins where a drive does: the middle of a tile lies there, so that a street along an
// axis is not cut lengthwise.
TileKey tile_of_block(const TileKey& block) {
  return divided({block.x + kBlocks / 2, block.y + kBlocks / 2}, kBlocks);
}

bool is_over(const ScanExtent& extent, const CellBox& blocks) {
  // Ascending by x: what lies before the box is left out at once.
  auto block = std::ranges::lower_bound(extent.blocks, TileKey{blocks.low.x, blocks.low.y});
  for (; block != extent.blocks.end() && block->x <= blocks.high.x; ++block) {
    if (block->y >= blocks.low.y && block->y <= blocks.high.y) return true;
  }
  return false;
}

struct PartRuns {
  std::vector<Eigen::Vector3d> points_m;
  std::vector<CellRun> runs;  // over the box
};

Result<PartRuns> runs_over(const SurfacePointReader& reader, std::size_t part, const CellBox& box,
                           double cell_m) {
  PartRuns found;
  SIGHTLINE_ASSIGN(found.points_m, reader.standing(part));
  std::vector<CellKey> keys(found.points_m.size());
  cell_keys(found.points_m, cell_m, keys);
  found.runs.resize(keys.size());
  found.runs.resize(find_runs(keys, found.runs));
  std::erase_if(found.runs, [&](const CellRun& run) { return !box.holds(run.key); });
  return found;
}

constexpr std::size_t kScansInBlock = 32;
constexpr std::uint32_t kNone = ~std::uint32_t{0};

struct Extents {
  std::vector<ScanExtent> of_parts;
  std::uint32_t outside = kNone;  // the first of them that has a point which the grid cannot hold
};
SIGHTLINE_FIELDS(Extents, of_parts, outside)

// Of points that are added one after the other.
class ExtentSum {
 public:
  explicit ExtentSum(const BlockGrid& grid) : grid_(grid), reach_m_(0x1.0p30 * grid.cell_m) {}

  void add(const Eigen::Vector3d& point_m) {
    // What is not finite is not held either.
    has_outside_ = has_outside_ || !(point_m.array().abs() < reach_m_).all();
    if (has_outside_) return;
    const Eigen::Vector2d at_m = point_m.head<2>();
    if (extent_.point_count++ == 0) extent_.low_m = extent_.high_m = at_m;
    extent_.low_m = extent_.low_m.cwiseMin(at_m);
    extent_.high_m = extent_.high_m.cwiseMax(at_m);
    const TileKey block = divided(tile_key(point_m, grid_.cell_m), grid_.block_cells);
    std::vector<TileKey>& blocks = extent_.blocks;
    if (blocks.empty() || blocks.back() != block) blocks.push_back(block);
  }

  [[nodiscard]] bool has_outside() const { return has_outside_; }
  ScanExtent take() {
    std::vector<TileKey>& blocks = extent_.blocks;
    std::ranges::sort(blocks);
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    return std::move(extent_);
  }

 private:
  BlockGrid grid_;
  double reach_m_;
  ScanExtent extent_;
  bool has_outside_ = false;
};

Result<void> add_part(const SurfacePoints& points, std::size_t part, ExtentSum& sum) {
  if (part == points.scans.size()) {
    for (const Eigen::Vector3d& point_m : points.points_m) sum.add(point_m);
    return {};
  }
  const PlacedScan& placed = points.scans[part];
  SIGHTLINE_ASSIGN(const Scan scan, points.store->read(placed.index));
  for (const Eigen::Vector3d& point_lidar_m : scan.points_m) {
    if (is_within_range(placed, point_lidar_m)) sum.add(placed.T_map_lidar * point_lidar_m);
  }
  return {};
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
  Extents found;
  for (const std::size_t part : parts_of_block(points, block)) {
    ExtentSum sum(grid);
    SIGHTLINE_TRY(add_part(points, part, sum));
    if (sum.has_outside() && found.outside == kNone) {
      found.outside = static_cast<std::uint32_t>(found.of_parts.size());
    }
    found.of_parts.push_back(sum.take());
  }
  return found;
}

// Nothing where part of it lies in memory.
std::optional<Digest> content_of_block(const SurfacePoints& points, std::size_t block) {
  std::vector<PlacedScan> scans;
  for (const std::size_t part : parts_of_block(points, block)) {
    if (part == points.scans.size()) return std::nullopt;
    scans.push_back(points.scans[part]);
  }
  return content_of_scans(*points.store, scans, written(std::string("extents")));
}

Error outside_grid(const SurfacePoints& points, std::size_t part, const std::string& pass) {
  const std::string where =
      part == points.scans.size() ? "" : concat(" of scan ", points.scans[part].index);
  return {
      ErrorCode::kInvalidArtifact,
      concat("a surface point", where, " is not finite or is more than 2^30 cells from the origin"),
      "", "pass " + pass};
}

}  // namespace

Eigen::AlignedBox2d extent_m(const CellBox& box, double cell_m) {
  return {Eigen::Vector2d(box.low.x, box.low.y) * cell_m,
          Eigen::Vector2d(box.high.x + 1.0, box.high.y + 1.0) * cell_m};
}

CellBox with_halo(const CellBox& box, std::int32_t halo_cells) {
  return {{box.low.x - halo_cells, box.low.y - halo_cells},
          {box.high.x + halo_cells, box.high.y + halo_cells}};
}

BlockGrid blocks_of_tiles(double cell_m, std::int32_t step_cells) {
  const double steps = std::ceil(kLeastTile_m / kBlocks / (step_cells * cell_m));
  return {cell_m, step_cells * static_cast<std::int32_t>(steps)};
}

CellTiles::CellTiles(std::vector<ScanExtent> extents, const BlockGrid& grid)
    : extents_(std::move(extents)), grid_(grid) {
  std::set<TileKey> tiles;
  for (const ScanExtent& extent : extents_) {
    for (const TileKey& block : extent.blocks) tiles.insert(tile_of_block(block));
  }
  tiles_.assign(tiles.begin(), tiles.end());
}

CellBox CellTiles::box(std::size_t tile) const {
  const auto first = [&](std::int32_t key) {
    return (key * kBlocks - kBlocks / 2) * grid_.block_cells;
  };
  const std::int32_t cells = kBlocks * grid_.block_cells;
  const TileKey low{first(tiles_[tile].x), first(tiles_[tile].y)};
  return {low, {low.x + cells - 1, low.y + cells - 1}};
}

std::vector<std::size_t> CellTiles::parts_over(const CellBox& cells) const {
  const CellBox blocks{divided(cells.low, grid_.block_cells),
                       divided(cells.high, grid_.block_cells)};
  std::vector<std::size_t> parts;
  for (std::size_t part = 0; part < extents_.size(); ++part) {
    if (is_over(extents_[part], blocks)) parts.push_back(part);
  }
  return parts;
}

Result<NdtCells> cells_over(const SurfacePointReader& reader, std::span<const std::size_t> parts,
                            const CellBox& box, double cell_m, int threads) {
  const auto at_once = static_cast<std::size_t>(threads_each(threads, 1));
  NdtCells cells;
  for (std::size_t first = 0; first < parts.size(); first += at_once) {
    const std::size_t count = std::min(at_once, parts.size() - first);
    std::vector<Result<PartRuns>> read(count, PartRuns{});
    parallel_for(count, threads, [&](std::size_t i) {
      read[i] = runs_over(reader, parts[first + i], box, cell_m);
    });
    for (const Result<PartRuns>& part : read) {
      if (!part) return part.error();
      add_runs(part->points_m, part->runs, cell_m, cells);
    }
  }
  return cells;
}

Result<std::vector<ScanExtent>> measure_extents(const PassContext& ctx, const SurfacePoints& points,
                                                const BlockGrid& grid, const std::string& pass) {
  std::vector<ScanExtent> extents(part_count_of(points));
  std::vector<std::uint32_t> outside(block_count(points), kNone);
  PassContext uncounted = ctx;  // what follows takes longer by far
  uncounted.progress_sink = nullptr;
  RecordWork<Extents> work;
  work.count = outside.size();
  work.content = [&](std::size_t block) { return content_of_block(points, block); };
  work.make = [&](std::size_t block, int /*threads*/) { return extents_of(points, grid, block); };
  work.take = [&](std::size_t block, const Extents& found) {
    const std::size_t first = block * kScansInBlock;
    if (found.of_parts.size() != std::min(kScansInBlock, extents.size() - first)) return false;
    if (found.outside != kNone && found.outside >= found.of_parts.size()) return false;
    std::ranges::copy(found.of_parts, extents.begin() + static_cast<std::ptrdiff_t>(first));
    outside[block] = found.outside;
    return true;
  };
  SIGHTLINE_TRY(work_in_parts(uncounted, work));
  for (std::size_t block = 0; block < outside.size(); ++block) {
    if (outside[block] == kNone) continue;
    return outside_grid(points, block * kScansInBlock + outside[block], pass);
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
    after.parts_sink = [&ctx, later](std::span<const PartName> parts) {
      std::vector<PartName> reported;
      for (const PartName& part : parts) reported.push_back(later(part));
      ctx.parts_sink(reported);
    };
  }
  return after;
}

}  // namespace sightline

#include "passes/map/surface/surface_tile.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <span>
#include <utility>

#include "formats/base/bytes.h"
#include "formats/base/parallel.h"
#include "passes/map/surface/patch_evidence.h"
#include "passes/map/surface/surface_candidates.h"
#include "passes/map/tiles/cell_tiles.h"

// A patch depends on its own points, returns and rays and on patches of shorter cells that cover
// it: a tile is made with the cells around it, whose patches are left to their own tiles.

namespace sightline {
namespace {

bool has_origin(const SurfacePoints& points, std::size_t part) {
  return part < points.scans.size() && points.store->has_origins();
}

// The plane over which rays of a scan are followed.
Eigen::AlignedBox2d followed_m(const PlacedScan& scan, const ScanExtent& extent) {
  const Eigen::Vector2d origin_m = scan.T_map_lidar.translation().head<2>();
  const Eigen::Vector2d longest_m = Eigen::Vector2d::Constant(kLongestPass_m);
  Eigen::AlignedBox2d points_m(extent.low_m, extent.high_m);
  points_m.extend(origin_m);
  return points_m.intersection(Eigen::AlignedBox2d(origin_m - longest_m, origin_m + longest_m));
}

// The parts of which a return or a ray may be over the cells, ascending.
std::vector<std::size_t> parts_seeing(const SurfacePoints& points, const CellTiles& tiles,
                                      const CellBox& cells, double cell_m) {
  const Eigen::AlignedBox2d cells_m(Eigen::Vector2d(cells.low.x - 1, cells.low.y - 1) * cell_m,
                                    Eigen::Vector2d(cells.high.x + 2, cells.high.y + 2) * cell_m);
  std::vector<std::size_t> parts = tiles.parts_over(cells);
  for (std::size_t part = 0; part < tiles.extents().size(); ++part) {
    const ScanExtent& extent = tiles.extents()[part];
    if (extent.point_count == 0 || !has_origin(points, part)) continue;
    if (cells_m.intersects(followed_m(points.scans[part], extent))) parts.push_back(part);
  }
  std::ranges::sort(parts);
  parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
  return parts;
}

Result<SeenScan> read_part(const SurfacePoints& points, const SurfacePointReader& reader,
                           std::size_t part) {
  SeenScan scan;
  SIGHTLINE_ASSIGN(scan.returns, reader.all(part));
  scan.has_origin = has_origin(points, part);
  if (scan.has_origin) scan.origin_m = points.scans[part].T_map_lidar.translation();
  return scan;
}

Result<void> look_at_scans(const SurfacePoints& points, const SurfacePointReader& reader,
                           std::span<const std::size_t> parts, int threads,
                           PatchEvidence& evidence) {
  const auto at_once = static_cast<std::size_t>(threads_each(threads, 1));
  for (std::size_t first = 0; first < parts.size(); first += at_once) {
    const std::size_t count = std::min(at_once, parts.size() - first);
    std::vector<Result<SeenScan>> read(count, SeenScan{});
    parallel_for(count, threads,
                 [&](std::size_t i) { read[i] = read_part(points, reader, parts[first + i]); });
    std::vector<SeenScan> scans;
    for (Result<SeenScan>& scan : read) {
      if (!scan) return scan.error();
      scans.push_back(std::move(*scan));
    }
    evidence.add(scans, threads);
  }
  evidence.finish(threads);
  return {};
}

// What became of the cells of a box that hold points; `map` is made of them and others.
CellTally tally_of(const NdtCells& cells, const NdtMap& map, const CellBox& box) {
  CellTally tally;
  for (std::size_t i = 0; i < cells.keys().size(); ++i) {
    if (!box.holds(cells.keys()[i])) continue;
    ++(cells.values()[i].count < 2 ? tally.sparse : tally.degenerate);
  }
  for (const Nd& nd : map.nds) tally.valid += box.holds(nd.key) ? 1 : 0;
  tally.degenerate -= tally.valid;
  return tally;
}

CellBox around(const CellTiles& tiles, std::size_t tile) {
  return with_halo(tiles.box(tile), kReachOfCandidates_cells);
}

// Where returns may lie on patches of these cells: beside them too.
Eigen::AlignedBox2d told_m(const CellBox& cells, double cell_m) {
  return extent_m(with_halo(cells, 2 * kLongestCell_cells), cell_m);
}

}  // namespace

std::optional<Digest> content_of_tile(const SurfacePoints& points,
                                      const SurfaceTileOptions& options, const CellTiles& tiles,
                                      std::size_t tile) {
  const CellBox near = around(tiles, tile);
  return content_of_parts(points, parts_seeing(points, tiles, near, options.cell_m),
                          told_m(near, options.cell_m),
                          written(tiles.box(tile), options.returns_per_ray));
}

Result<SurfaceTile> surface_of_tile(const SurfacePoints& points, const SurfaceTileOptions& options,
                                    const CellTiles& tiles, std::size_t tile, int threads) {
  const CellBox box = tiles.box(tile);
  const CellBox near = around(tiles, tile);
  const std::vector<std::size_t> seeing = parts_seeing(points, tiles, near, options.cell_m);
  const SurfacePointReader reader(points, seeing, told_m(near, options.cell_m));
  SurfaceTile made;
  NdtMap map;
  {
    SIGHTLINE_ASSIGN(const NdtCells cells,
                     cells_over(reader, tiles.parts_over(near), near, options.cell_m, threads));
    // Cells of two points take part in longer ones.
    map = map_of_cells(std::span(&cells, 1), {options.cell_m, options.tile_m, 2}, threads);
    made.cells = tally_of(cells, map, box);
  }
  const std::vector<SurfaceCandidate> candidates =
      surface_candidates(map, static_cast<std::uint32_t>(options.min_points));
  map.nds = {};
  for (const SurfaceCandidate& candidate : candidates) made.patches.push_back(candidate.patch);
  const PatchGrid grid(made.patches, options.cell_m);
  PatchEvidence evidence(grid, candidates.size());
  SIGHTLINE_TRY(look_at_scans(points, reader, seeing, threads, evidence));
  made.patches = solid_patches(candidates, grid, evidence, options.returns_per_ray);
  std::erase_if(made.patches, [&](const SurfacePatch& patch) { return !box.holds(patch.key); });
  sort_patches({{}, options.cell_m, options.tile_m, {}}, made.patches);
  return made;
}

void sort_patches(const Surface& surface, std::vector<SurfacePatch>& patches) {
  std::vector<std::pair<SurfaceOrder, std::size_t>> order;
  order.reserve(patches.size());
  for (const SurfacePatch& patch : patches)
    order.emplace_back(order_of(patch, surface), order.size());
  std::ranges::sort(order);
  std::vector<SurfacePatch> sorted;
  sorted.reserve(patches.size());
  for (const auto& [place, i] : order) sorted.push_back(patches[i]);
  patches = std::move(sorted);
}

void PatchesByTile::add(std::span<const SurfacePatch> patches) {
  std::map<TileKey, std::vector<const SurfacePatch*>> of_tile;
  for (const SurfacePatch& patch : patches) {
    of_tile[tile_of(patch.key, order_.cell_m, order_.tile_m)].push_back(&patch);
  }
  ByteWriter writer;
  writer.reserve(patches.size() * kEncodedPatch);
  for (const auto& [tile, members] : of_tile) {
    for (const SurfacePatch* patch : members) encode(*patch, writer);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& [tile, members] : of_tile) {
    pieces_[tile].push_back({count_, members.size()});
    count_ += members.size();
  }
  if (written_) written_ = growing_.append(writer.bytes());
}

Result<void> PatchesByTile::finish() {
  SIGHTLINE_TRY(written_);
  bytes_ = growing_.take();
  return {};
}

std::vector<TileKey> PatchesByTile::tiles() const {
  std::vector<TileKey> tiles;
  for (const auto& [tile, pieces] : pieces_) tiles.push_back(tile);
  return tiles;
}

Result<std::vector<SurfacePatch>> PatchesByTile::read(const TileKey& tile) const {
  std::vector<SurfacePatch> patches;
  const auto found = pieces_.find(tile);
  if (found == pieces_.end()) return patches;
  for (const Piece& piece : found->second) {
    SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes,
                     bytes_.read(piece.first * kEncodedPatch, piece.count * kEncodedPatch));
    ByteReader reader(bytes);
    for (std::uint64_t i = 0; i < piece.count; ++i) decode(reader, patches.emplace_back());
  }
  return patches;
}

Result<std::vector<SurfacePatch>> PatchesByTile::of_tile(const TileKey& tile) const {
  SIGHTLINE_ASSIGN(std::vector<SurfacePatch> patches, read(tile));
  sort_patches(order_, patches);
  return patches;
}

Result<std::vector<SurfacePatch>> PatchesByTile::over(const Eigen::AlignedBox2d& box_m) const {
  std::vector<SurfacePatch> patches;
  const auto tile_at = [&](const Eigen::Vector2d& corner_m) {
    return tile_key({corner_m.x(), corner_m.y(), 0.0}, order_.tile_m);
  };
  const TileKey low = tile_at(box_m.min());
  const TileKey high = tile_at(box_m.max());
  for (std::int32_t x = low.x; x <= high.x; ++x) {
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      SIGHTLINE_ASSIGN(const std::vector<SurfacePatch> of_tile, read({x, y}));
      for (const SurfacePatch& patch : of_tile) {
        if (box_m.contains(patch.centre_m.head<2>())) patches.push_back(patch);
      }
    }
  }
  sort_patches(order_, patches);
  return patches;
}

}  // namespace sightline

#include "passes/map/tiles/tile_cells.h"

#include <algorithm>
#include <vector>

#include "formats/base/parallel.h"

namespace sightline {
namespace {

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

}  // namespace

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

}  // namespace sightline

#include "passes/map/surface/patch_evidence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/parallel.h"
#include "formats/grid/cell_index.h"
#include "passes/map/tiles/cell_tiles.h"

// Evidence of many scans is gathered and then counted cell by cell, so that a cell's patches and
// their counts are fetched from memory once.

namespace sightline {
namespace {

// Of a scan.
constexpr std::size_t kReturnsCounted = 32000;
constexpr std::size_t kRaysFollowed = 8000;

// Calls use(position) at floor(n s) with s = t - floor(t - g) no fraction: every ring is met alike.
// At most about `most` of `count`; the same rule as that of measured error
// (schemas/definitions.md).
template <class Use>
void spread_evenly(std::size_t count, std::size_t most, const Use& use) {
  constexpr double kGolden = 0.6180339887498949;
  const double wanted = static_cast<double>(count) / static_cast<double>(most);
  const double stride = wanted < 1.0 + kGolden ? 1.0 : std::floor(wanted - kGolden) + kGolden;
  for (double n = 0.0;; n += 1.0) {
    const auto position = static_cast<std::size_t>(n * stride);
    if (position >= count) return;
    use(position);
  }
}

std::uint64_t count_spread(std::uint64_t count, std::size_t most) {
  std::uint64_t used = 0;
  spread_evenly(count, most, [&](std::size_t) { ++used; });
  return used;
}

// Without a branch.
void count_once_more(std::uint8_t& counter) {
  counter = static_cast<std::uint8_t>(counter + (counter < 255 ? 1 : 0));
}

// What one of several threads does in a cell: it has the patches of some runs for itself.
struct CellShare {
  std::uint32_t cell = 0;
  std::span<const std::uint32_t> things;
  std::size_t part = 0;
  std::size_t parts = 1;
  [[nodiscard]] bool has(std::uint32_t patch) const {
    constexpr std::uint32_t kRun = 64;
    return parts == 1 || patch / kRun % parts == part;
  }
};

std::size_t parts_of(int threads) { return static_cast<std::size_t>(threads_each(threads, 1)); }

// Calls visit(share) for each cell that has things, ascending, and each of parts_of(threads).
template <class Visit>
void visit_cells(const PatchGrid& grid, const SortedByCell& sorted, int threads,
                 const Visit& visit) {
  const std::size_t parts = parts_of(threads);
  parallel_for(parts, threads, [&](std::size_t part) {
    for (std::uint32_t cell = 0; cell < grid.cell_count(); ++cell) {
      const std::span<const std::uint32_t> things = sorted.things_of(cell);
      if (!things.empty()) visit(CellShare{cell, things, part, parts});
    }
  });
}

// The numbers of the cells in which points lie.
void find_cells(std::span<const Eigen::Vector3d> points_m, const PatchGrid& grid, int threads,
                std::vector<std::uint32_t>& numbers) {
  constexpr std::size_t kBatch = 4096;
  static_assert(PatchGrid::kNone == SortedByCell::kNone);
  numbers.resize(points_m.size());
  parallel_for((points_m.size() + kBatch - 1) / kBatch, threads, [&](std::size_t batch) {
    const std::size_t first = batch * kBatch;
    const std::size_t count = std::min(kBatch, points_m.size() - first);
    std::vector<CellKey> cells(count);
    cell_keys(points_m.subspan(first, count), grid.cell_m(), cells);
    for (std::size_t i = 0; i < count; ++i) {
      const bool goes_on = i > 0 && cells[i] == cells[i - 1];
      numbers[first + i] = goes_on ? numbers[first + i - 1] : grid.number_of(cells[i]);
    }
  });
}

}  // namespace

PatchEvidence::PatchEvidence(const PatchGrid& grid, std::size_t patch_count)
    : grid_(grid), box_m_(grid.box_m()), counts_(patch_count) {}

void PatchEvidence::add(std::span<const SeenScan> scans, int threads) {
  std::vector<FollowedRays> followed(scans.size());
  parallel_for(scans.size(), threads, [&](std::size_t i) {
    if (!scans[i].has_origin) return;
    const std::vector<Eigen::Vector3d>& points_m = scans[i].returns.points_m;
    spread_evenly(points_m.size(), kRaysFollowed, [&](std::size_t ray) {
      follow_ray(scans[i].origin_m, points_m[ray], grid_, followed[i]);
    });
  });
  for (const FollowedRays& of_scan : followed) {
    add_rays(of_scan);
    if (rays_.visits.size() >= kVisitsAtOnce) count_passes(threads);
  }
  for (const SeenScan& scan : scans) add_returns(scan, threads);
}

void PatchEvidence::finish(int threads) {
  count_passes(threads);
  count_returns(threads);
}

void PatchEvidence::add_returns(const SeenScan& scan, int threads) {
  const std::vector<Eigen::Vector3d>& points_m = scan.returns.points_m;
  const std::vector<std::uint8_t>& has_moved = scan.returns.has_moved;
  const std::size_t count = points_m.size();
  spread_evenly(count, scan.has_origin ? kReturnsCounted : count, [&](std::size_t i) {
    if (!has_moved.empty() && has_moved[i] != 0) return;
    if (!box_m_.contains(points_m[i])) return;
    returns_m_.push_back(points_m[i]);
    if (returns_m_.size() == kReturnsAtOnce) count_returns(threads);
  });
}

void PatchEvidence::add_rays(const FollowedRays& followed) {
  const auto before = static_cast<std::uint32_t>(rays_.rays.size());
  rays_.rays.insert(rays_.rays.end(), followed.rays.begin(), followed.rays.end());
  for (RayVisit visit : followed.visits) {
    visit.ray += before;
    rays_.visits.push_back(visit);
  }
}

void PatchEvidence::count_returns(int threads) {
  find_cells(returns_m_, grid_, threads, numbers_);
  sorted_.sort(numbers_, grid_.cell_count());
  std::vector<PatchLanes::Places> places_of(parts_of(threads));
  visit_cells(grid_, sorted_, threads, [&](const CellShare& share) {
    PatchLanes::Places& places = places_of[share.part];
    places.clear();
    for (const std::uint32_t& i : share.things) {
      __builtin_prefetch(&returns_m_[sorted_.later(i)]);
      places.add(grid_.lanes().place_of(returns_m_[i]));
    }
    for (const std::uint32_t patch : grid_.patches_of(share.cell)) {
      if (share.has(patch)) count_returns(patch, share.things, places);
    }
  });
  returns_m_.clear();
}

void PatchEvidence::count_returns(std::uint32_t patch, std::span<const std::uint32_t> returns,
                                  const PatchLanes::Places& places) {
  const PatchLanes::Patch lanes = grid_.lanes().patch(patch);
  SquareCounts& counts = counts_[patch];
  for (std::size_t first = 0; first < returns.size(); first += PatchLanes::kAtOnce) {
    const auto squares = lanes.squares_of(places, first);
    const std::size_t count = std::min(PatchLanes::kAtOnce, returns.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      int square = squares[i];
      if (square == PatchLanes::kUnsure) {
        square = grid_.plane(patch).square_of_return(returns_m_[returns[first + i]]);
      }
      if (square >= 0) count_once_more(counts.returns[static_cast<std::size_t>(square)]);
    }
  }
}

void PatchEvidence::count_passes(int threads) {
  numbers_.clear();
  for (const RayVisit& visit : rays_.visits) numbers_.push_back(visit.cell);
  sorted_.sort(numbers_, grid_.cell_count());
  struct Visit {
    PatchLanes::Ray lanes;
    float enter_m, leave_m;
    const FollowedRay* ray;
  };
  std::vector<std::vector<Visit>> visits_of(parts_of(threads));
  visit_cells(grid_, sorted_, threads, [&](const CellShare& share) {
    std::vector<Visit>& visits = visits_of[share.part];
    visits.clear();
    for (const std::uint32_t& i : share.things) {
      __builtin_prefetch(&rays_.visits[sorted_.later(i)]);
      const RayVisit& visit = rays_.visits[i];
      const FollowedRay& ray = rays_.rays[visit.ray];
      visits.push_back({ray.lanes, visit.enter_m, visit.leave_m, &ray});
    }
    for (const std::uint32_t patch : grid_.patches_of(share.cell)) {
      if (!share.has(patch)) continue;
      const PatchLanes::Patch lanes = grid_.lanes().patch(patch);
      for (const Visit& visit : visits) {
        if (!lanes.may_cross(visit.lanes, visit.enter_m, visit.leave_m)) continue;
        const int square = square_passed(*visit.ray, patch, share.cell, grid_);
        if (square >= 0) count_once_more(counts_[patch].passes[static_cast<std::size_t>(square)]);
      }
    }
  });
  rays_.rays.clear();
  rays_.visits.clear();
}

CountedSights counted_sights(std::uint64_t return_count) {
  return {count_spread(return_count, kReturnsCounted), count_spread(return_count, kRaysFollowed)};
}

}  // namespace sightline

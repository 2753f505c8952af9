#include "passes/map/surface/surface_candidates.h"

#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "passes/matching/localizer.h"

// The constants below were chosen against the exact triangles of lanes (tests/bench/depth_bench).

namespace sightline {
namespace {

// A patch reaches a little over its cell wherever its centre is.
constexpr double kHalfSidePerCell = 0.72;
// What is thicker than walls with windows and noise is no one surface: leaves, boughs, pickets.
constexpr double kMostThickness_m = 0.08;
// A coarse one reaches across the gap even where that lies between two coarse cells.
constexpr double kCoarseHalfSidePerCell = 0.9;
// Rays that end at a square of what is thick, for each that goes on. Layers of leaves lie one
// behind the other: one that stops every second ray would make a crown solid all the same.
constexpr double kReturnsPerPassOfThick = 2.0;
// With more open squares among those that stop rays, nothing is known of the others: a fence.
constexpr int kStoppingPerOpen = 4;
constexpr double kSteepestGround = 0.9;  // height of its normal: 25 degrees
// Cells so many times as long close gaps between scan lines. Lines 2 degrees apart leave 1.4 m open
// at the sensor's own height on a wall 40 m off, however often it drives by.
constexpr std::array<int, 3> kCoarseFactors = {2, 4, 8};
// Windows set back by 0.2 m in a wall are part of it, where they close a gap.
constexpr double kMostCoarseThickness_m = 0.12;
// Second spread of a coarse cell, in its cells: a single line lies in any plane.
constexpr double kLeastWidthPerCell = 0.06;
// A gap has no other patch this near to its plane.
constexpr double kSamePlane_m = 0.15;

SurfacePatch patch_of(const Nd& nd, double cell_m, double half_side_m) {
  SurfacePatch patch;
  patch.key = cell_key(nd.mean_m, cell_m);
  patch.centre_m = nd.mean_m;
  patch.normal = nd.eigenvectors.col(2);
  if (patch.normal.z() < 0.0) patch.normal = -patch.normal;
  patch.half_side_m = half_side_m;
  return patch;
}

double thickness_m(const Nd& nd) { return std::sqrt(nd.eigenvalues_m2[2]); }

bool has(std::uint64_t squares, int square) { return (squares >> square & 1) != 0; }

// Whether one of the first patches of the grid is solid there.
bool is_covered(const Eigen::Vector3d& place_m, const PatchGrid& grid,
                std::span<const SurfacePatch> first) {
  for (const std::uint32_t i : grid.patches_at(cell_key(place_m, grid.cell_m()))) {
    if (i >= first.size()) return false;
    const PatchPlane& plane = grid.plane(i);
    if (std::abs(plane.normal.dot(place_m - plane.centre_m)) > kSamePlane_m) continue;
    const int square = plane.square_of(place_m);
    if (square >= 0 && has(first[i].solid, square)) return true;
  }
  return false;
}

// What may be taken for solid between squares that stop rays.
std::uint64_t known_between(const SurfaceCandidate& candidate, std::uint64_t stopping,
                            std::uint64_t open) {
  const std::uint64_t hull = convex_hull(stopping);
  const bool is_porous = kStoppingPerOpen * std::popcount(open & hull) > std::popcount(stopping);
  if (candidate.is_thick || is_porous) return 0;
  // Of walls the scan lines leave gaps between low and high; what is open beside may be an alley.
  const bool is_coarse_wall = candidate.factor > 1 && candidate.patch.normal.z() < kSteepestGround;
  return (is_coarse_wall ? between_rows(stopping) : hull) & ~open;
}

void clear_covered(const PatchPlane& plane, const PatchGrid& grid,
                   std::span<const SurfacePatch> first, std::uint64_t& squares) {
  for (int square = 0; square < kSquaresOfPatch; ++square) {
    if (has(squares, square) && is_covered(plane.middle_m(square), grid, first)) {
      squares &= ~(std::uint64_t{1} << square);
    }
  }
}

struct Place {
  int column = 0;
  int row = 0;
};

// Positive where c lies to the left of the way from a to b.
int turn(const Place& a, const Place& b, const Place& c) {
  return (b.column - a.column) * (c.row - a.row) - (b.row - a.row) * (c.column - a.column);
}

// Andrew's monotone chain: one half of the hull of places in order, from the first to the last.
std::vector<Place> half_hull(const std::vector<Place>& places) {
  std::vector<Place> hull;
  for (const Place& place : places) {
    while (hull.size() >= 2 && turn(hull[hull.size() - 2], hull.back(), place) <= 0) {
      hull.pop_back();
    }
    hull.push_back(place);
  }
  return hull;
}

bool is_left_of_all(const std::vector<Place>& way, const Place& place) {
  for (std::size_t i = 1; i < way.size(); ++i) {
    if (turn(way[i - 1], way[i], place) < 0) return false;
  }
  return true;
}

template <class Holds>
std::uint64_t squares_where(const Holds& holds) {
  std::uint64_t squares = 0;
  for (int square = 0; square < kSquaresOfPatch; ++square) {
    if (holds(static_cast<std::size_t>(square))) squares |= std::uint64_t{1} << square;
  }
  return squares;
}

}  // namespace

std::vector<SurfaceCandidate> surface_candidates(const NdtMap& cells, std::uint32_t min_points) {
  std::vector<SurfaceCandidate> candidates;
  for (const Nd& nd : cells.nds) {
    if (nd.point_count < min_points) continue;
    candidates.push_back({patch_of(nd, cells.cell_m, kHalfSidePerCell * cells.cell_m),
                          thickness_m(nd) > kMostThickness_m, 1});
  }
  for (const int factor : kCoarseFactors) {
    const NdtMap coarse = coarse_map(cells, factor);
    for (const Nd& nd : coarse.nds) {
      const double width_m = std::sqrt(nd.eigenvalues_m2[1]);
      if (thickness_m(nd) > kMostCoarseThickness_m) continue;
      if (width_m < kLeastWidthPerCell * coarse.cell_m) continue;
      candidates.push_back(
          {patch_of(nd, cells.cell_m, kCoarseHalfSidePerCell * coarse.cell_m), false, factor});
    }
  }
  return candidates;
}

std::vector<SurfacePatch> solid_patches(const std::vector<SurfaceCandidate>& candidates,
                                        const PatchGrid& grid, const PatchEvidence& evidence,
                                        double returns_per_ray) {
  std::vector<SurfacePatch> patches;
  patches.reserve(candidates.size());
  std::size_t shorter_count = 0;  // candidates of shorter cells: what covers depends on no order
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const SquareCounts& counts = evidence.counts()[i];
    const double returns_per_pass =
        (candidates[i].is_thick ? kReturnsPerPassOfThick : 1.0) * returns_per_ray;
    const std::uint64_t stopping = stopping_squares(counts, returns_per_pass);
    SurfacePatch patch = candidates[i].patch;
    patch.solid =
        stopping | known_between(candidates[i], stopping, open_squares(counts, returns_per_pass));
    if (i > 0 && candidates[i].factor != candidates[i - 1].factor) shorter_count = i;
    if (candidates[i].factor > 1) {
      patch.solid &= ~stopping;
      clear_covered(grid.plane(static_cast<std::uint32_t>(i)), grid,
                    std::span(patches).first(shorter_count), patch.solid);
    }
    patches.push_back(patch);
  }
  std::erase_if(patches, [](const SurfacePatch& patch) { return patch.solid == 0; });
  return patches;
}

CandidateOrder candidate_order_of(const SurfacePatch& patch, const Surface& surface) {
  const bool is_fine = patch.half_side_m < kCoarseHalfSidePerCell * surface.cell_m;
  const int factor = is_fine ? 1
                             : static_cast<int>(std::lround(
                                   patch.half_side_m / (kCoarseHalfSidePerCell * surface.cell_m)));
  const CellKey key{floor_divide(patch.key.x, factor), floor_divide(patch.key.y, factor),
                    floor_divide(patch.key.z, factor)};
  const double cell_m = factor * surface.cell_m;
  double tile_m = surface.tile_m;  // as coarse_map() has it
  while (!is_tiling(cell_m, tile_m)) tile_m += surface.tile_m;
  return {factor, tile_of(key, cell_m, tile_m), key};
}

std::uint64_t stopping_squares(const SquareCounts& counts, double returns_per_pass) {
  return squares_where([&](std::size_t i) {
    return counts.returns[i] > 0 && returns_per_pass * counts.passes[i] <= counts.returns[i];
  });
}

std::uint64_t open_squares(const SquareCounts& counts, double returns_per_pass) {
  return squares_where(
      [&](std::size_t i) { return returns_per_pass * counts.passes[i] > counts.returns[i]; });
}

std::uint64_t between_rows(std::uint64_t squares) {
  std::uint64_t from_below = squares;
  std::uint64_t from_above = squares;
  for (int row = 1; row < kPatchSquares; ++row) {
    from_below |= from_below << kPatchSquares;
    from_above |= from_above >> kPatchSquares;
  }
  return from_below & from_above;
}

std::uint64_t convex_hull(std::uint64_t squares) {
  std::vector<Place> places;  // column by column, from below
  Place low{kPatchSquares, kPatchSquares};
  Place high{-1, -1};
  for (int column = 0; column < kPatchSquares; ++column) {
    for (int row = 0; row < kPatchSquares; ++row) {
      if (!has(squares, kPatchSquares * row + column)) continue;
      places.push_back({column, row});
      low = {std::min(low.column, column), std::min(low.row, row)};
      high = {std::max(high.column, column), std::max(high.row, row)};
    }
  }
  const std::vector<Place> below = half_hull(places);
  const std::vector<Place> above = half_hull({places.rbegin(), places.rend()});
  return squares | squares_where([&](std::size_t i) {
           const Place place{static_cast<int>(i) % kPatchSquares,
                             static_cast<int>(i) / kPatchSquares};
           // A line of squares has no inside, and nothing lies left of both its directions but
           // itself.
           return place.column >= low.column && place.column <= high.column &&
                  place.row >= low.row && place.row <= high.row && is_left_of_all(below, place) &&
                  is_left_of_all(above, place);
         });
}

}  // namespace sightline

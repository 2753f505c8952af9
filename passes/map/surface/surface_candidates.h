#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/surface.h"
#include "passes/map/surface/patch_evidence.h"

namespace sightline {

// Which squares of a patch stop a ray. Bits as in SurfacePatch::solid.

// Those where at least `returns_per_pass` times as many rays ended as were followed through.
std::uint64_t stopping_squares(const SquareCounts& counts, double returns_per_pass);

// Those through which rays were followed, and fewer ended there than that.
std::uint64_t open_squares(const SquareCounts& counts, double returns_per_pass);

// The squares whose middle lies in the convex hull of the middles of these, with them.
std::uint64_t convex_hull(std::uint64_t squares);

// Those in one column between two of these, with them: above one and below the other.
std::uint64_t between_rows(std::uint64_t squares);

// A patch that may become a part of a surface.
struct SurfaceCandidate {
  SurfacePatch patch;     // its solid squares are not known yet
  bool is_thick = false;  // no one surface: nothing is known between its returns
  int factor = 1;         // of its cell; those of longer cells close gaps that shorter ones leave
};

// One for each cell of enough points; after them those of longer cells that see a plane. Ascending
// by factor.
std::vector<SurfaceCandidate> surface_candidates(const NdtMap& cells, std::uint32_t min_points);

// The candidates with the squares that stop rays; none where no square does. `grid` and `evidence`
// are those of the candidates' patches; `returns_per_ray` were counted of all scans.
std::vector<SurfacePatch> solid_patches(const std::vector<SurfaceCandidate>& candidates,
                                        const PatchGrid& grid, const PatchEvidence& evidence,
                                        double returns_per_ray);

// So many of the shortest cells around a cell decide what its patch and those of longer cells there
// are; a multiple of the longest.
inline constexpr std::int32_t kReachOfCandidates_cells = 32;
// The longest cell, in the shortest.
inline constexpr std::int32_t kLongestCell_cells = 8;

// The order in which surface_candidates() gives them: by factor, tile and key of their cell.
using CandidateOrder = std::tuple<int, TileKey, CellKey>;
CandidateOrder candidate_order_of(const SurfacePatch& patch, const Surface& surface);

}  // namespace sightline

#pragma once

#include <cstdint>
#include <vector>

#include "formats/surroundings/ndt_map.h"
#include "passes/map/surface/patch_evidence.h"

namespace sightline {

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
// are those of the candidates' patches.
std::vector<SurfacePatch> solid_patches(const std::vector<SurfaceCandidate>& candidates,
                                        const PatchGrid& grid, const PatchEvidence& evidence);

}  // namespace sightline

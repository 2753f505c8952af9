#pragma once

#include <cstdint>

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

}  // namespace sightline

#pragma once

#include <cstdint>

#include "passes/map/surface/patch_evidence.h"

namespace sightline {

// Which squares of a patch stop a ray. Bits as in SurfacePatch::solid.

// Those where at least as many rays ended as went on; a ray that was followed stands for
// `returns_per_ray` of those whose returns were counted.
std::uint64_t stopping_squares(const SquareCounts& counts, double returns_per_ray);

// Those through which rays went on, more than ended there.
std::uint64_t open_squares(const SquareCounts& counts, double returns_per_ray);

// The squares whose middle lies in the convex hull of the middles of these, with them.
std::uint64_t convex_hull(std::uint64_t squares);

}  // namespace sightline

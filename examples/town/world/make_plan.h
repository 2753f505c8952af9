#pragma once

#include <cstdint>

#include "examples/town/world/plan.h"

namespace sightline::town {

// The driven line is at least length_m long. Every kind of street comes once before any comes
// again, in an order, with widths, lengths and turns that depend on the seed alone.
TownPlan make_plan(std::uint64_t seed, double length_m);

// Once around a block of houses, counter-clockwise, `lap_m` (at least 200) long; without side
// streets but at the corners.
TownPlan make_round_plan(std::uint64_t seed, double lap_m);

}  // namespace sightline::town

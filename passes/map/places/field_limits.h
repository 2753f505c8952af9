#pragma once

#include <cstddef>

#include "formats/base/result.h"
#include "passes/map/places/field_options.h"

// What places everywhere take, and how many are too many (tests/bench/README.md, "The field").

namespace sightline {

// From here to the map, on average over sensors of 16 and 64 beams: seconds of one core.
inline constexpr double kCpuOfPlace_s = 0.07;

// What a compile takes for so many places, with as many ranges and looks as the defaults have.
double memory_of_places_mib(double count);

// Whether the raster of so much ground fits in options.memory_gib. Error: too-many-places.
Result<void> check_ground(double ground_m2, const ChooseFieldSitesOptions& options);
// Whether so many places fit in it, or are asked for. Error: too-many-places.
Result<void> check_places(std::size_t count, const ChooseFieldSitesOptions& options);

}  // namespace sightline

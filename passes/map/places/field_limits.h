#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "passes/pass/options.h"

// What places everywhere take, and how many are too many (tests/bench/README.md, "The field").

namespace sightline {

struct ChooseFieldSitesOptions {
  double spacing_m = 2.0;
  double width_m = 2.0;     // of a vehicle
  double height_m = 2.0;    // of it, above ground
  std::string from;         // "x, y" in world coordinates, m; empty: the largest stretch
  std::string within;       // "x0, y0, x1, y1" in world coordinates, m; empty: the whole map
  double memory_gib = 2.0;  // that annotating the places may take
  int most_places = 0;      // 0: as many as that memory holds
};
std::vector<OptionField> option_fields(ChooseFieldSitesOptions& options);

// From here to the map, on average over sensors of 16 and 64 beams: seconds of one core.
inline constexpr double kCpuOfPlace_s = 0.07;

// What a compile takes for so many places, with as many ranges and looks as the defaults have.
double memory_of_places_mib(double count);

// Whether the raster of so much ground fits in options.memory_gib. Error: too-many-places.
Result<void> check_ground(double ground_m2, const ChooseFieldSitesOptions& options);
// Whether so many places fit in it, or are asked for. Error: too-many-places.
Result<void> check_places(std::size_t count, const ChooseFieldSitesOptions& options);

}  // namespace sightline

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "formats/geodesy.h"
#include "formats/map/compiled_map.h"
#include "formats/reader/reader.h"
#include "passes/weakness/weak_stretches.h"

namespace sightline {

// A Lanelet2 map with what a compiled map answers along its lanes, as tags of lanelets and, where
// no answer is good enough or the map is weak (schemas/definitions.md, "Weak stretches"), as
// polygons of the lane's width that Autoware's environment adaptor reads: examples/exports.md lists
// them. All else is as it was, byte for byte; what an earlier export added is replaced.
struct Lanelet2Options {
  double area_limit_m = 0.0;  // a limit of the map; 0: its widest
  // A place is weak where the best look's predicted error leaves less of the limit; 0: where it is
  // beyond it.
  double weak_margin = WeakStretchOptions().least_margin;
};

struct Lanelet2Export {
  std::string text;
  std::vector<std::string> outside;  // the ids of lanelets without any answer
  std::size_t lanelet_count = 0;
  std::size_t area_count = 0;  // unmet
  std::size_t weak_area_count = 0;
};

// `reader` has the same map open, for the localizer whose errors it holds. Places of the file are
// latitudes and longitudes where the world is known; else local_x and local_y, which count from the
// world's origin or from where exported clouds do, whichever is nearer to the map.
// Errors: those of read_lanelets(); missing-field (no lanelet), no-overlap (no place has an answer:
// says how far away they are), bad-argument (the map has no such limit).
Result<Lanelet2Export> to_lanelet2(const CompiledMap& map, const MapReader& reader,
                                   const World& world, const std::string& text,
                                   const Lanelet2Options& options);

// "010" of 0.10 m, "0125" of 0.125 m: the decimals of a limit, two at least, without the point.
std::string limit_suffix(double limit_m);

}  // namespace sightline

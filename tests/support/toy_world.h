#pragma once

#include <string_view>

#include "formats/annotation/sites.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/surface_points.h"

// Worlds drawn as text, for tests. One character is a square of 1 m; the last line is y in [0, 1),
// lines above it lie further along +y; columns run along +x from x = 0.
//
//   #  solid, 4 m high: points on each side that faces another kind of square
//   .  flat ground at z = 0
//   o  a pole of 0.1 m radius, 4 m high, on ground
//   @  ground with a site above its middle, sensor at 1.8 m
//   (space) nothing

namespace sightline {

struct ToyWorld {
  SurfacePoints points;  // a regular lattice of 0.1 m, without noise
  Sites sites;           // in reading order of the text; all of run 0, 1 m apart by s_m
};
ToyWorld draw_world(std::string_view text);

// An NdtMap made directly of random valid NDs, dense enough for factors to be interesting: `count`
// cells around the origin, within +-half_extent_m horizontally and 3 m vertically.
NdtMap random_ndt_map(std::uint64_t seed, int count, double half_extent_m, double cell_m = 2.0,
                      double tile_m = 64.0);

}  // namespace sightline

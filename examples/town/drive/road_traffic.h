#pragma once

#include <vector>

#include "examples/town/drive/traffic.h"

namespace sightline::town {

// Traffic of a hard world: cars ahead and oncoming ones where the place has room for them, and
// lorries that the vehicle passes slowly on roads with guard rails or walls: for about 60 m one
// hides a side of the view. None in a car park and on a plaza.
std::vector<Mover> draw_road_traffic(const Town& town, std::uint64_t drive, double duration_s,
                                     double times);

TownMesh moving_road_mesh(const Town& town, const std::vector<Mover>& movers, const Moment& moment);

// Patches of fog, smoke or spray around a sensor, in its frame, that cover about a tenth of the
// view; the same during a drive.
TownMesh fog_mesh(std::uint64_t seed);

}  // namespace sightline::town

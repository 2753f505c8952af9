#pragma once

#include "tests/formats/map/random_map.h"

namespace sightline {

// A map like `map` but for some NDs that are gone, new or elsewhere, sites that are gone, moved or
// look farther or less far: what a later release may differ in. Where `moves_frame`, its frame lies
// a tile from the other's.
CompiledMap changed_map(const CompiledMap& map, std::uint64_t seed, bool moves_frame = false);

}  // namespace sightline

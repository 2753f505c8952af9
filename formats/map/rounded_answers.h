#pragma once

#include "formats/map/compiled_map.h"

namespace sightline {

// Rounds the places of sites and what is predicted there to what a small map keeps
// (kSmallLength_m, kSmallShare, kSmallRotation): along a street most bits are then equal. Choices,
// flags and reasons stay as they are.
void round_answers(CompiledMap& map);

}  // namespace sightline

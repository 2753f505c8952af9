#pragma once

#include "tests/formats/map/random_map.h"

namespace sightline {

// The map that fuzzed deltas are for: small, with layers large enough to be packed anew.
inline CompiledMap fuzzed_base() {
  return random_map(
      {.seed = 2, .site_count = 3, .nd_count = 120, .extent_m = 25.0, .model_size = 90});
}

}  // namespace sightline

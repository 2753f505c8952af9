#pragma once

#include "formats/base/result.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {

// NDs that a pass made tile by tile, as one map.
inline Result<NdtMap> whole_nds(const Result<TiledNds>& tiled) {
  if (!tiled) return tiled.error();
  return tiled->whole();
}

}  // namespace sightline

#pragma once

#include <cstddef>
#include <vector>

#include "formats/surroundings/surface.h"

namespace sightline {

// All tiles of a surface, or why there is none.
inline Result<Surface> whole(const Result<TiledSurface>& surface) {
  if (!surface) return surface.error();
  return surface->whole();
}

inline std::vector<std::byte> to_bytes(const Surface& surface) {
  ByteWriter writer;
  encode(surface, writer);
  return writer.take();
}

}  // namespace sightline

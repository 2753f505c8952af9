#pragma once

#include <cstddef>
#include <vector>

#include "formats/base/result.h"
#include "formats/surroundings/surface.h"

namespace sightline {

// A stored table that a pass made, as the struct that holds all rows.
template <class X>
Result<X> whole_rows(const Result<StoredTable<X>>& table) {
  if (!table) return table.error();
  return table->whole();
}

inline std::vector<std::byte> to_bytes(const Surface& surface) {
  ByteWriter writer;
  encode(surface, writer);
  return writer.take();
}

}  // namespace sightline

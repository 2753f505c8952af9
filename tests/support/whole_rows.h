#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "formats/annotation/by_family.h"
#include "formats/base/result.h"
#include "formats/surroundings/surface.h"

namespace sightline {

// A stored table that a pass made, as the struct that holds all rows.
template <class X>
Result<X> whole_rows(const Result<StoredTable<X>>& table) {
  if (!table) return table.error();
  return table->whole();
}
template <class X>
Result<ByFamily<X>> whole_rows(const Result<ByFamily<StoredTable<X>>>& both) {
  if (!both) return both.error();
  return whole_of(*both);
}

// What a pass made of the looks that take every return.
template <class X>
X of_ranges(ByFamily<X> both) {
  return std::move(both.ranges);
}
template <class X>
Result<X> of_ranges(Result<ByFamily<X>> both) {
  if (!both) return both.error();
  return std::move(both->ranges);
}

inline std::vector<std::byte> to_bytes(const Surface& surface) {
  ByteWriter writer;
  encode(surface, writer);
  return writer.take();
}

}  // namespace sightline

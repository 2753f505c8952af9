#pragma once

#include "formats/annotation/at_rest.h"
#include "formats/base/result.h"

namespace sightline {

// A table that a pass made at rest, whole.
template <class X>
Result<X> whole_rows(const Result<AtRest<X>>& table) {
  if (!table) return table.error();
  return table->whole();
}

}  // namespace sightline

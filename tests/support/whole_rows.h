#pragma once

#include "formats/base/result.h"
#include "formats/tables/stored_table.h"

namespace sightline {

// A stored table that a pass made, as the struct that holds all rows.
template <class X>
Result<X> whole_rows(const Result<StoredTable<X>>& table) {
  if (!table) return table.error();
  return table->whole();
}

}  // namespace sightline

#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "formats/tables/stored_table.h"

namespace sightline {

// The table of one kind of looks: of those that take every return within a range, or of those that
// take a sample, which `both` must then have.
template <HasRows X>
X of_kind(X both, bool is_of_samples) {
  if (is_of_samples) return std::move(both.of_samples.front());
  both.of_samples.clear();
  return both;
}

// Consecutive sites by the looks of one kind. Error: cannot-read.
template <HasRows X>
Result<X> rows_of_kind(const StoredTable<X>& table, bool is_of_samples, std::size_t first,
                       std::size_t count) {
  X found = RowsOf<X>::part_of(of_kind(table.head(), is_of_samples), first, count);
  RowsOf<X>::resize(found, count);
  const auto fill = [&](std::uint64_t done, std::uint64_t here) -> Result<void> {
    SIGHTLINE_ASSIGN(X some, table.rows(first + done, here));
    ByteWriter writer;
    RowsOf<X>::encode(of_kind(std::move(some), is_of_samples), 0, here, writer);
    ByteReader reader(writer.bytes());
    RowsOf<X>::decode(reader, found, done, here);
    return {};
  };
  SIGHTLINE_TRY(stored_table::visit_stretches(count, fill));
  return found;
}

}  // namespace sightline

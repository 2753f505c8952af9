#pragma once

#include <cstddef>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/rows_of_kind.h"
#include "formats/base/result.h"

namespace sightline {

// The factors of a map's sites by looks of one kind: those that take every return within a range,
// or those that take a sample, which the table must then have.
struct FactorsOfKind {
  const StoredTable<FactorTable>& factors;
  bool is_of_samples = false;

  // Without values.
  [[nodiscard]] const FactorTable& head() const {
    return is_of_samples ? factors.head().of_samples.front() : factors.head();
  }
  // Of `count` sites in a row. Error: cannot-read.
  [[nodiscard]] Result<FactorTable> of_sites(std::size_t first, std::size_t count) const {
    return rows_of_kind(factors, is_of_samples, first, count);
  }
};

}  // namespace sightline

#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/base/hash.h"
#include "formats/base/result.h"
#include "formats/tables/stored_table.h"
#include "passes/pass/pass_context.h"
#include "passes/pass/work_in_parts.h"

namespace sightline {

// Fills the rows of a part, which are zeros: those of its sites in their order.
using FillPart = std::function<Result<void>(std::size_t part, ByFamily<MeasuredError>& rows)>;

// Sites by part, what fills them, and what decides that besides the empty rows (PartedWork).
struct MeasuredParts {
  std::vector<std::vector<std::size_t>> sites;
  FillPart fill;
  std::function<std::optional<Digest>(std::size_t part)> content;
  PartOrder order = PartOrder::kSideBySide;
};

// Makes the rows of `measured`, which has none, part by part (work_in_parts.h). `at_once` parts
// side by side. Errors: of the lowest part that failed; disk-full, cannot-write.
Result<ByFamily<StoredTable<MeasuredError>>> fill_in_parts(const PassContext& ctx,
                                                           const MeasuredParts& parts, int at_once,
                                                           const ByFamily<MeasuredError>& measured);

}  // namespace sightline

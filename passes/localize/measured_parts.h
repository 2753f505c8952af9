#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/base/result.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// Fills the rows of a part, which are zeros: those of its sites in their order.
using FillPart = std::function<Result<void>(std::size_t part, MeasuredError& rows)>;

// Fills the rows of `measured`, which are zeros, part by part (work_in_parts.h): part i is the
// sites sites_of_part[i]. `threads` parts side by side. Error: of the lowest part that failed.
Result<void> fill_in_parts(const PassContext& ctx,
                           const std::vector<std::vector<std::size_t>>& sites_of_part,
                           const FillPart& fill, int threads, MeasuredError& measured);

}  // namespace sightline

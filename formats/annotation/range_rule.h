#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "formats/annotation/predicted_error.h"
#include "formats/annotation/range_table.h"

namespace sightline {

// The range (an index) that a site takes from its own predictions, before its neighbours are asked,
// as defined in schemas/definitions.md, "Error model and choice of range"; nothing where no range
// is good enough.

// The paper's: the shortest range whose predicted mean error is within the limit.
std::optional<std::size_t> range_by_mean(const PredictedError& predicted, std::size_t site,
                                         double limit_m);

// The shortest with P(error <= limit) >= p.
std::optional<std::size_t> range_by_probability(const PredictedError& predicted, std::size_t site,
                                                std::size_t limit, double p);

// The same by the rule and the thresholds of a table.
std::optional<std::size_t> own_range(const RangeTable& table, const PredictedError& predicted,
                                     std::size_t site, std::size_t limit);

// What a table holds at a site for one limit, with what is predicted there.
struct Answer {
  Look look;
  double probability = 0.0;  // P(error <= limit)
  double error_m = 0.0;      // mean
  std::uint8_t flags = 0;    // of range_table.h
  Reason reason = Reason::kNone;
};
Answer answer_of(const RangeTable& table, const PredictedError& predicted, std::size_t site,
                 std::size_t limit);

}  // namespace sightline

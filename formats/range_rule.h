#pragma once

#include <cstddef>
#include <optional>

#include "formats/predicted_error.h"
#include "formats/range_table.h"

namespace sightline {

// The range (an index) that a site takes from its own predictions, before its neighbours are asked,
// as defined in schemas/definitions.md, "Error model and choice of range"; nothing where no range
// is good enough. `p` is p* of the limit, from 0 to 1; under every rule a higher p asks for more.

// The paper's: the shortest range whose predicted mean error is within the limit.
std::optional<std::size_t> range_by_mean(const PredictedError& predicted, std::size_t site,
                                         double limit_m);

// The shortest with P(error <= limit) >= p.
std::optional<std::size_t> range_by_probability(const PredictedError& predicted, std::size_t site,
                                                std::size_t limit, double p);

// The range with the least p (1 - P) + (1 - p) R / longest, the shorter on a tie, P being the
// largest P(error <= limit) up to R: it goes on looking farther as long as a metre more buys enough.
// Nothing where no P reaches 1/2.
std::optional<std::size_t> range_by_worth(const PredictedError& predicted, std::size_t site,
                                          std::size_t limit, double p);

// The same by the rule and the thresholds of a table.
std::optional<std::size_t> own_range(const RangeTable& table, const PredictedError& predicted,
                                     std::size_t site, std::size_t limit);

}  // namespace sightline

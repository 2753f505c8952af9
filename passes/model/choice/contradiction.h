#pragma once

#include <cstdint>
#include <optional>

#include "formats/annotation/measured_error.h"
#include "formats/annotation/sites.h"
#include "passes/model/promise/selection.h"

// Whether the errors that a compile measured contradict a promise.

namespace sightline {

// The probability of `least` or more hits in `count` trials that hit with probability `p`, 0 < p
// < 1.
double binomial_tail(std::uint32_t count, std::uint32_t least, double p);

struct Contradiction {
  std::uint32_t block_count = 0;  // of route with answered, measured sites
  std::uint32_t missed_blocks =
      0;                      // the sum over blocks of the share of sites that miss, rounded down
  double share_within = 0.0;  // of these sites, those within the limit
};

// Measured sites with an answer are cut into blocks of at least 60 m of their runs (one where a run
// is shorter). Sites of a block see the same walls and count as one trial. The promise that at most
// the share alpha misses is contradicted if so many misses have a probability below 0.01 (one-sided
// exact binomial test). `measured`: at the looks of the choice.
std::optional<Contradiction> contradiction_of(const Sites& sites, const MeasuredError& measured,
                                              const Choice& choice, double limit_m, double alpha);

}  // namespace sightline

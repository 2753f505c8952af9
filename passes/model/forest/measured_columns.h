#pragma once

#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"

// What history is made of, as columns of a map's factors, so that it can be made again from the
// map.

namespace sightline {

// `measured_mean_m`, `measured_p90_m` and `measured_lost_share` of each site and range, -1 at sites
// that the drive did not measure. Those of a second drive, added after the first, are
// `measured_mean_m[2]` and so on.
// `measured_is_independent` follows, 1 everywhere, where neither the map nor the model that
// annotates it were made of the drive: its errors may judge a choice that did not use them.
ByFamily<FactorTable> with_measured_columns(const ByFamily<FactorTable>& factors,
                                            const ByFamily<MeasuredError>& measured,
                                            bool is_independent = false);

bool has_measured_columns(const FactorTable& factors);

// Back again, drive by drive; the other numbers of the rows are 0. None where the table has no such
// columns.
// By the looks that take a sample where their table has columns of the drive too.
std::vector<ByFamily<MeasuredError>> measured_of_columns(const ByFamily<FactorTable>& factors);

// [drive]: whether its columns say that it is independent.
std::vector<bool> independence_of_columns(const FactorTable& factors);

}  // namespace sightline

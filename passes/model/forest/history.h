#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/sites.h"
#include "passes/model/forest/feature_rows.h"

// What an earlier drive found at a place, told as features (schemas/definitions.md, "Measured
// history"). Whoever learns from it must take the label from another drive.

namespace sightline {

// Names of the features, "history_known" first; logs are natural, of errors in metres.
const std::vector<std::string>& history_features();
bool is_history_feature(const std::string& name);

// Features of every site and range, all 0 where no site that the drive measured lies within 6 m.
struct History {
  std::vector<std::uint8_t> is_known;  // [site]
  std::vector<float> values;           // [site][range][feature]
};

// `measured` is of these sites, at any number of ranges.
History history_of(const Sites& sites, const MeasuredError& measured);

// What history is made of, as columns of a map's factors, so that it can be made again from the
// map: `measured_mean_m`, `measured_p90_m` and `measured_lost_share` of each site and range, -1 at
// sites that the drive did not measure.
FactorTable with_measured_columns(const FactorTable& factors, const MeasuredError& measured);
// Back again; the other numbers of the rows are 0. None where the table has no such columns.
std::optional<MeasuredError> measured_of_columns(const FactorTable& factors);

// The rows with the features of history put in before range_m; null: no history anywhere.
FeatureRows with_history(const FeatureRows& rows, const History* history);

}  // namespace sightline

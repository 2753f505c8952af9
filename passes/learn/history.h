#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/measured_error.h"
#include "formats/sites.h"
#include "passes/learn/feature_rows.h"

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

// The rows with the features of history put in before range_m; null: no history anywhere.
FeatureRows with_history(const FeatureRows& rows, const History* history);

}  // namespace sightline

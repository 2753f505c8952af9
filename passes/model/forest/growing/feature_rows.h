#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/base/result.h"

namespace sightline {

// Inputs of a forest, one row per (site, range) in that order: some factors, then the range in
// metres. In float, because the grower compares in float: rows then fall where they were grown.
struct FeatureRows {
  std::vector<std::string> names;  // ends in "range_m"
  std::size_t row_count = 0;
  std::vector<float> values;  // [row][feature]

  [[nodiscard]] const float* row(std::size_t i) const { return &values[i * names.size()]; }
  [[nodiscard]] float& at(std::size_t row, std::size_t feature) {
    return values[row * names.size() + feature];
  }
};

// The map factors of the paper (schemas/definitions.md), eleven of them.
const std::vector<std::string>& paper_factors();

// The named factors of every site and range. Errors: mismatched-inputs where the table lacks one,
// invalid-artifact, naming factor, site and range, where a value is not a finite float.
Result<FeatureRows> gather_features(const FactorTable& table,
                                    const std::vector<std::string>& factors);

// XXH3 of the features of one site at all ranges.
std::uint64_t features_digest(const FeatureRows& features, std::size_t site,
                              std::size_t range_count);

}  // namespace sightline

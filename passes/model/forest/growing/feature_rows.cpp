#include "passes/model/forest/growing/feature_rows.h"

#include <algorithm>
#include <cmath>

#include "formats/base/hash.h"

namespace sightline {
namespace {

Result<std::vector<std::size_t>> columns_of(const FactorTable& table,
                                            const std::vector<std::string>& factors) {
  std::vector<std::size_t> columns;
  for (const std::string& factor : factors) {
    const auto found = std::find(table.factors.begin(), table.factors.end(), factor);
    if (found == table.factors.end()) {
      return Error{ErrorCode::kMismatchedInputs,
                   "the factor table has no factor '" + factor + "', which the model needs"};
    }
    columns.push_back(static_cast<std::size_t>(found - table.factors.begin()));
  }
  return columns;
}

}  // namespace

const std::vector<std::string>& paper_factors() {
  static const std::vector<std::string> kFactors = {
      "feature_count", "d1_count",        "d2_count",       "d3_count",  "d1_ratio",     "d2_ratio",
      "d3_ratio",      "occupancy_ratio", "normal_entropy", "r_average", "score_entropy"};
  return kFactors;
}

Result<FeatureRows> gather_features(const FactorTable& table,
                                    const std::vector<std::string>& factors) {
  SIGHTLINE_ASSIGN(const std::vector<std::size_t> columns, columns_of(table, factors));
  FeatureRows rows;
  rows.names = factors;
  rows.names.emplace_back("range_m");
  rows.row_count = std::size_t{table.site_count} * table.looks.size();
  rows.values.reserve(rows.row_count * rows.names.size());
  for (std::size_t site = 0; site < table.site_count; ++site) {
    for (std::size_t range = 0; range < table.looks.size(); ++range) {
      for (const std::size_t column : columns) {
        const auto value = static_cast<float>(table.at(site, range, column));
        if (!std::isfinite(value)) {
          return Error{ErrorCode::kInvalidArtifact,
                       "factor '" + table.factors[column] + "' is not a finite number", "",
                       "site " + std::to_string(site) + ", range " +
                           format_double(table.looks[range].range_m) + " m"};
        }
        rows.values.push_back(value);
      }
      rows.values.push_back(static_cast<float>(table.looks[range].range_m));
    }
  }
  return rows;
}

std::uint64_t features_digest(const FeatureRows& features, std::size_t site,
                              std::size_t range_count) {
  const std::size_t count = range_count * features.names.size();
  return xxh3(std::as_bytes(std::span(features.values).subspan(site * count, count)));
}

}  // namespace sightline

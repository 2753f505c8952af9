#include "formats/reader/protection_table.h"

namespace sightline {
namespace {

constexpr double kLeastRisk = 0.01;

// By tests/bench/integrity, protection_bench --fit.
constexpr std::array<ProtectionRow, kPlaceGroups> kRows = {{
    {.place = "street",
     .block_count = 166,
     .covariance_factor = 0.852,
     .percent_factors = {20.08, 5.642, 3.813, 3.84},
     .percent_errors = {0.5456, 0.4324, 0.08606, 0.02359},
     .least_likelihood = 2.552,
     .least_scored_share = 0.9322},
    {.place = "tunnel",
     .block_count = 166,
     .covariance_factor = 0.986,
     .percent_factors = {20.08, 5.642, 3.813, 3.84},
     .percent_errors = {0.5456, 0.4324, 0.08606, 0.02359},
     .least_likelihood = 2.136,
     .least_scored_share = 0.8552},
    {.place = "open-road",
     .block_count = 166,
     .covariance_factor = 1.19,
     .percent_factors = {20.08, 5.642, 3.813, 3.84},
     .percent_errors = {0.5456, 0.4324, 0.08606, 0.02359},
     .least_likelihood = 1.854,
     .least_scored_share = 0.8356},
    {.place = "field",
     .block_count = 166,
     .covariance_factor = 1.19,
     .percent_factors = {20.08, 5.642, 3.813, 3.84},
     .percent_errors = {0.5456, 0.4324, 0.08606, 0.02359},
     .least_likelihood = 1.854,
     .least_scored_share = 0.8356},
    {.place = "any",
     .block_count = 166,
     .covariance_factor = 1,
     .percent_factors = {20.08, 5.642, 3.813, 3.84},
     .percent_errors = {0.5456, 0.4324, 0.08606, 0.02359},
     .least_likelihood = 2.11,
     .least_scored_share = 0.8471},
}};

// By number of kind: unknown, lane, canyon, avenue, open, crossing, tunnel, corridor, open-road,
// field, forest, hall.
constexpr std::array<PlaceGroup, 12> kGroups = {
    PlaceGroup::kAny,      PlaceGroup::kStreet, PlaceGroup::kStreet, PlaceGroup::kStreet,
    PlaceGroup::kStreet,   PlaceGroup::kStreet, PlaceGroup::kTunnel, PlaceGroup::kTunnel,
    PlaceGroup::kOpenRoad, PlaceGroup::kField,  PlaceGroup::kAny,    PlaceGroup::kAny};

}  // namespace

PlaceGroup group_of_kind(unsigned place_kind) {
  return place_kind < kGroups.size() ? kGroups[place_kind] : PlaceGroup::kAny;
}

const ProtectionRow& protection_row(PlaceGroup group) {
  return kRows[static_cast<std::size_t>(group)];
}

ProtectionFactors protection_factors(const ProtectionRow& row, double risk) {
  if (risk >= kLeastRisk) return row.percent_factors;
  return {kUnavailable, kUnavailable, kUnavailable, kUnavailable};
}

}  // namespace sightline

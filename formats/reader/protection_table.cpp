#include "formats/reader/protection_table.h"

namespace sightline {
namespace {

constexpr double kLeastRisk = 0.01;

// By tests/bench/integrity, protection_bench --fit; the raised shares by worlds of their own
// (tests/bench/README.md).
constexpr std::array<ProtectionRow, kPlaceGroups> kRows = {{
    {.place = "street",
     .block_count = 154,
     .covariance_factor = 0.928,
     .percent_factors = {10.94, 3.766, 3.617, 3.391},
     .percent_errors = {0.4322, 0.03481, 0.08427, 0.00105},
     .least_likelihood = 2.578,
     .least_scored_share = 0.9329,
     .least_raised_share = 0.5},
    {.place = "tunnel",
     .block_count = 128,
     .covariance_factor = 0.96,
     .percent_factors = {20.36, 2.665, 1.95, 3.007},
     .percent_errors = {0.6742, 0.03728, 0.0187, 0.001113},
     .least_likelihood = 2.205,
     .least_scored_share = 0.8717,
     .least_raised_share = 0.5},
    {.place = "open-road",
     .block_count = 136,
     .covariance_factor = 1.52,
     .percent_factors = {5.363, 15.04, 5.675, 12.87},
     .percent_errors = {0.629, 0.7581, 0.07465, 0.06129},
     .least_likelihood = 1.822,
     .least_scored_share = 0.7755,
     .least_raised_share = 0.0209},
    {.place = "field",
     .block_count = 136,
     .covariance_factor = 1.52,
     .percent_factors = {4.285, 6.458, 2.174, 4.319},
     .percent_errors = {0.5726, 0.4457, 0.02224, 0.03067},
     .least_likelihood = 2.832,
     .least_scored_share = 0.945,
     .least_raised_share = 0.4104},
    {.place = "any",
     .block_count = 554,
     .covariance_factor = 1,
     .percent_factors = {12.11, 8.262, 3.024, 9.019},
     .percent_errors = {0.5799, 0.4562, 0.05643, 0.02742},
     .least_likelihood = 1.965,
     .least_scored_share = 0.7936,
     .least_raised_share = 0.0209},
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

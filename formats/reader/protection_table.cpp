#include "formats/reader/protection_table.h"

namespace sightline {
namespace {

constexpr double kLeastRisk = 0.01;

// By tests/bench/integrity, protection_bench --fit.
constexpr std::array<ProtectionRow, kPlaceGroups> kRows = {{
    {.place = "street",
     .block_count = 128,
     .covariance_factor = 0.862,
     .percent_factors = {20.62, 5.579, 3.785, 3.221},
     .percent_errors = {0.5434, 0.4336, 0.08581, 0.02359},
     .least_likelihood = 2.557,
     .least_scored_share = 0.9329},
    {.place = "tunnel",
     .block_count = 128,
     .covariance_factor = 0.936,
     .percent_factors = {20.62, 5.579, 3.785, 3.221},
     .percent_errors = {0.5434, 0.4336, 0.08581, 0.02359},
     .least_likelihood = 2.135,
     .least_scored_share = 0.8539},
    {.place = "open-road",
     .block_count = 128,
     .covariance_factor = 1.21,
     .percent_factors = {20.62, 5.579, 3.785, 3.221},
     .percent_errors = {0.5434, 0.4336, 0.08581, 0.02359},
     .least_likelihood = 1.846,
     .least_scored_share = 0.8347},
    {.place = "any",
     .block_count = 128,
     .covariance_factor = 1,
     .percent_factors = {20.62, 5.579, 3.785, 3.221},
     .percent_errors = {0.5434, 0.4336, 0.08581, 0.02359},
     .least_likelihood = 2.095,
     .least_scored_share = 0.8459},
}};

// By number of kind: unknown, lane, canyon, avenue, open, crossing, tunnel, corridor, open-road,
// field, forest, hall.
constexpr std::array<PlaceGroup, 12> kGroups = {
    PlaceGroup::kAny,      PlaceGroup::kStreet,   PlaceGroup::kStreet, PlaceGroup::kStreet,
    PlaceGroup::kStreet,   PlaceGroup::kStreet,   PlaceGroup::kTunnel, PlaceGroup::kTunnel,
    PlaceGroup::kOpenRoad, PlaceGroup::kOpenRoad, PlaceGroup::kAny,    PlaceGroup::kAny};

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

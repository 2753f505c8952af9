#include "formats/reader/protection_table.h"

namespace sightline {
namespace {

constexpr double kLeastRisk = 0.01;

// By tests/bench/integrity, protection_bench --fit.
constexpr std::array<ProtectionRow, kPlaceGroups> kRows = {{
    {.place = "street"},
    {.place = "tunnel"},
    {.place = "open-road"},
    {.place = "any"},
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

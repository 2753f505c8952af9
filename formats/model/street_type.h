#pragma once

#include <cstdint>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/record/fields.h"

namespace sightline {

// What kind of street a site lies in, from the map's own factors (schemas/definitions.md,
// "Street types").
enum class StreetType : std::uint8_t { kUnknown, kLane, kCanyon, kAvenue, kOpen, kCrossing };
template <>
inline constexpr auto kNamesOf<StreetType> = enum_names("unknown", "lane", "canyon", "avenue",
                                                        "open", "crossing");
inline constexpr std::size_t kStreetTypeCount = kNamesOf<StreetType>.size();

// [site]; all kUnknown where the table has no occupancy_ratio.
std::vector<StreetType> street_types(const FactorTable& factors);

}  // namespace sightline

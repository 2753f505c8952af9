#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "formats/annotation/factor_table.h"

namespace sightline {

// What kind of street a site lies in, told from the map's own factors (schemas/definitions.md,
// "Street types").
enum class StreetType : std::uint8_t { kUnknown, kLane, kCanyon, kAvenue, kOpen, kCrossing };
inline constexpr std::size_t kStreetTypeCount = 6;

std::string_view street_type_name(StreetType type);  // "unknown", "lane", ...

// [site]; all kUnknown where the table has no occupancy_ratio.
std::vector<StreetType> street_types(const FactorTable& factors);

}  // namespace sightline

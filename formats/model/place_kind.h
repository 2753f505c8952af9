#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/site_column.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/record/fields.h"
#include "formats/tables/stored_table.h"

namespace sightline {

// What kind of place a site lies in, from the map's own factors (schemas/definitions.md, "Kinds of
// place"). Maps and models store the number, so numbers are never reused.
enum class PlaceKind : std::uint8_t {
  kUnknown,
  kLane,      // walls close by
  kCanyon,    // a street between houses
  kAvenue,    // a wide one
  kOpen,      // walls are far
  kCrossing,  // near walls, and streets that lead far out of sight
  kTunnel,    // as a lane, but weakly constrained along one direction
  kCorridor,  // as a canyon or avenue, the same
  kOpenRoad,  // as a crossing or open, the same
  kField,     // as a crossing or open, weakly constrained along all directions
  kForest,    // many trunks and poles
  kHall       // walls are near, but constrain weakly along all directions: a car park
};
template <>
inline constexpr auto kNamesOf<PlaceKind> = enum_names("unknown", "lane", "canyon", "avenue",
                                                       "open", "crossing", "tunnel", "corridor",
                                                       "open-road", "field", "forest", "hall");
inline constexpr std::size_t kPlaceKindCount = kNamesOf<PlaceKind>.size();

// The column of sites that holds these numbers in a map.
inline constexpr std::string_view kPlaceKindColumn = "place_kind";

// [site], each by itself; all kUnknown where the table has no occupancy_ratio.
std::vector<PlaceKind> place_kinds(const FactorTable& factors);

// Each site takes the most frequent kind within 10 m along its run: its own if that is one of
// several, else the first of these in the order of PlaceKind.
std::vector<PlaceKind> smoothed(const Sites& sites, const std::vector<PlaceKind>& kinds);

// [site], smoothed. `factors` are of these sites, or of none: then all are kUnknown. Error:
// cannot-read.
Result<std::vector<PlaceKind>> place_kinds(const Sites& sites,
                                           const StoredTable<FactorTable>& factors);

// By its number in that column; kUnknown where it is none of these.
PlaceKind place_kind_of(float number);

// By the columns of a map; kUnknown where it has none.
PlaceKind kind_at(const std::vector<SiteColumn>& columns, std::size_t site);

}  // namespace sightline

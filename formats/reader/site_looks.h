#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "formats/reader/site_errors.h"

// Columns of a map with the looks of a vehicle that tracks ("Looks while tracking" in
// schemas/definitions.md): two for each limit, by its number. A look that is good enough is its
// number among the map's looks; one that is not is -1 - number.

namespace sightline {

inline constexpr std::array<std::string_view, 2> kTrackingLookColumns = {"tracking_look_",
                                                                         "tracking_probability_"};

inline std::string tracking_look_column(std::size_t column, std::size_t limit) {
  return std::string(kTrackingLookColumns[column]) + std::to_string(limit);
}

// [limit]: those two. Empty where a map has none.
using TrackingLookColumns = std::vector<std::array<MapErrors::Column, 2>>;

}  // namespace sightline

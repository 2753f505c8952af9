#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace sightline {

// Fields that hold the strength of the return, as the usual writers name them.
inline bool is_intensity_name(std::string_view name) {
  return name == "intensity" || name == "Intensity" || name == "scalar_intensity" ||
         name == "scalar_Intensity" || name == "reflectivity" || name == "i";
}

// Fields that hold the time of a point, as the usual drivers name them.
inline bool is_time_name(std::string_view name) {
  constexpr std::array<std::string_view, 8> kNames = {"t",           "time",        "timestamp",
                                                      "offset_time", "time_offset", "timeStamp",
                                                      "time_stamps", "gps_time"};
  return std::ranges::find(kNames, name) != kNames.end();
}

}  // namespace sightline

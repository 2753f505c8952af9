#pragma once

#include <string_view>

namespace sightline {

// Fields that hold the strength of the return, as the usual writers name them.
inline bool is_intensity_name(std::string_view name) {
  return name == "intensity" || name == "Intensity" || name == "scalar_intensity" ||
         name == "scalar_Intensity" || name == "reflectivity" || name == "i";
}

}  // namespace sightline

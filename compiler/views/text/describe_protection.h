#pragma once

#include <cstddef>
#include <string>

#include "formats/map/compiled_map.h"

namespace sightline {

// A line on how wrong the pose of a vehicle that tracks may be at a site, by its kind of place and
// its measured errors (formats/reader/site_protection.h).
std::string describe_protection(const CompiledMap& map, std::size_t site);

}  // namespace sightline

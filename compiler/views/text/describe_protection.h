#pragma once

#include <cstddef>
#include <string>

#include "formats/map/compiled_map.h"
#include "formats/reader/site_protection.h"

namespace sightline {

inline constexpr double kShownRisk = 0.01;  // per 60 m and axis

// Bounds of the errors of a vehicle that tracks, at a site of the map, for kShownRisk.
SiteProtection protection_at(const CompiledMap& map, std::size_t site);

// A line on how wrong the pose of a vehicle that tracks may be at a site, by its kind of place and
// its measured errors (formats/reader/site_protection.h).
std::string describe_protection(const CompiledMap& map, std::size_t site);

}  // namespace sightline

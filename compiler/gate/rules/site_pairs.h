#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/map/compiled_map.h"

namespace sightline {

// Which sites of two maps are the same place: each site's nearest of the other map, by the sensor's
// origin in world coordinates and within that map's reach, the lower number on a tie: what a
// vehicle would read there.
struct SitePairs {
  std::vector<std::optional<std::uint32_t>> old_of_new;  // [site of the new map]
  std::vector<std::optional<std::uint32_t>> new_of_old;  // [site of the old map]
};

SitePairs pair_sites(const CompiledMap& new_map, const CompiledMap& old_map);

}  // namespace sightline

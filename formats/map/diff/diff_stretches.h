#pragma once

#include <cstdint>
#include <map>

#include "formats/map/diff/diff_places.h"

// Gathers what changed into stretches of route.

namespace sightline {

struct NdCounts {
  std::uint64_t added = 0;
  std::uint64_t removed = 0;
  std::uint64_t moved = 0;
  std::uint64_t stayed = 0;

  [[nodiscard]] std::uint64_t changed() const { return added + removed + moved; }
};

// NDs of tiles that changed, by the site of the new map that is nearest to them.
using NdsBySite = std::map<std::uint32_t, NdCounts>;

// Stretches of the new map by run and s, then those that only the old map has. A stretch begins and
// ends with a site whose answer changed or around which the place did; between two such sites lie
// at most options.join_m, and it is shorter than options.longest_m. Also counts the changed NDs
// that lie in none of them.
void find_stretches(const CompiledMap& before, const CompiledMap& after,
                    const ComparedSites& compared, const NdsBySite& nds, MapDiff& diff);

}  // namespace sightline

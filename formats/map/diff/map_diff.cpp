#include "formats/map/diff/map_diff.h"

#include <algorithm>

namespace sightline {

bool MapDiff::is_same() const {
  const bool has_same_blocks =
      std::all_of(blocks.begin(), blocks.end(), [](const BlockDiff& block) {
        return block.added == 0 && block.removed == 0 && block.changed == 0;
      });
  return before.root_digest == after.root_digest && has_same_blocks;
}

std::vector<double> common_limits_m(const MapDiff& diff) {
  std::vector<double> common_m;
  for (const LimitDiff& limit : diff.limits) {
    if (limit.is_common()) common_m.push_back(limit.limit_m);
  }
  return common_m;
}

}  // namespace sightline

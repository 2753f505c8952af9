#include "compiler/gate/rules/shared_limits.h"

#include <algorithm>

namespace sightline {

std::vector<SharedLimit> shared_limits(const GateInput& input) {
  std::vector<SharedLimit> shared;
  const std::vector<double>& now_m = input.map->predicted.limits_m;
  const std::vector<double>& old_m = input.old_map->predicted.limits_m;
  for (std::size_t i = 0; i < now_m.size(); ++i) {
    const auto found = std::ranges::find(old_m, now_m[i]);
    if (found == old_m.end()) continue;
    shared.push_back({now_m[i], i, static_cast<std::size_t>(found - old_m.begin())});
  }
  return shared;
}

}  // namespace sightline

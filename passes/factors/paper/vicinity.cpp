#include "passes/factors/paper/vicinity.h"

#include <algorithm>

namespace sightline {

Vicinity vicinity_of(const Eigen::Vector3d& p_map_m, std::span<const Nd> nds,
                     std::span<const std::uint32_t> candidates,
                     const std::vector<double>& ranges_m) {
  struct Neighbour {
    double distance_m;
    std::uint32_t nd;
  };
  std::vector<Neighbour> neighbours;
  neighbours.reserve(candidates.size());
  for (const std::uint32_t nd : candidates) {
    const double distance_m = (nds[nd].mean_m - p_map_m).norm();
    if (distance_m <= ranges_m.back()) neighbours.push_back({distance_m, nd});
  }
  std::sort(neighbours.begin(), neighbours.end(), [&](const Neighbour& a, const Neighbour& b) {
    if (a.distance_m != b.distance_m) return a.distance_m < b.distance_m;
    return nds[a.nd].key < nds[b.nd].key;
  });
  Vicinity vicinity;
  vicinity.ranges_m = ranges_m;
  for (const Neighbour& neighbour : neighbours) {
    vicinity.nd_index.push_back(neighbour.nd);
    vicinity.distance_m.push_back(neighbour.distance_m);
  }
  for (const double range_m : ranges_m) {
    const auto beyond =
        std::upper_bound(vicinity.distance_m.begin(), vicinity.distance_m.end(), range_m);
    vicinity.end.push_back(static_cast<std::size_t>(beyond - vicinity.distance_m.begin()));
  }
  return vicinity;
}

}  // namespace sightline

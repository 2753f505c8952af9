#include "passes/trajectory/pieces/separate_piece.h"

#include <algorithm>

namespace sightline {

void separate_piece(const std::vector<Pose>& T_own_lidar, const ScanRange& piece,
                    const Sites& sites, std::vector<Pose>& T_map_lidar) {
  constexpr double kApart_m = 2000.0;
  double farthest_m = 0.0;
  for (const Site& site : sites.sites) farthest_m = std::max(farthest_m, site.p_map_m.x());
  for (const Pose& pose : T_map_lidar) {
    farthest_m = std::max(farthest_m, pose.translation().x());
  }
  double lowest_m = T_own_lidar[piece.begin].translation().x();
  for (std::size_t k = piece.begin; k < piece.end; ++k) {
    lowest_m = std::min(lowest_m, T_own_lidar[k].translation().x());
  }
  for (std::size_t k = piece.begin; k < piece.end; ++k) {
    T_map_lidar[k] = T_own_lidar[k];
    T_map_lidar[k].translation().x() += farthest_m + kApart_m - lowest_m;
  }
}

}  // namespace sightline

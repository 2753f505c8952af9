#include "passes/trajectory/pieces/own_pieces.h"

#include <algorithm>

namespace sightline {

std::vector<OwnPiece> pieces_of_drive(const Trajectory& own) {
  std::vector<OwnPiece> pieces;
  for (std::size_t k = 0; k < own.poses.size(); ++k) {
    const bool begins = k == 0 || own.poses[k].piece != own.poses[k - 1].piece;
    if (begins) pieces.push_back({k, k});
    pieces.back().end = k + 1;
  }
  return pieces;
}

void lay_aside(const std::vector<Pose>& T_own_lidar, const OwnPiece& piece, const Sites& sites,
               std::vector<Pose>& T_map_lidar) {
  constexpr double kAside_m = 2000.0;
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
    T_map_lidar[k].translation().x() += farthest_m + kAside_m - lowest_m;
  }
}

}  // namespace sightline

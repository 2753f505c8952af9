#pragma once

#include <string>
#include <vector>

#include "formats/geometry.h"

namespace sightline {

// A street to match in: the points of its map, and scans with their poses.
struct MatchWorld {
  std::string name;
  double leaf_m = 0.5;
  std::vector<Eigen::Vector3d> map_points_m;
  std::vector<std::vector<Eigen::Vector3d>> scans;
  std::vector<Pose> T_map_scan;
};

// The set kitti_0005 of tests/README.md where it is there with its poses, else a generated town.
// Even scans of the first make the map; of the second one drive maps and another is matched.
MatchWorld make_match_world();

}  // namespace sightline

#pragma once

#include <cstdint>
#include <vector>

#include "formats/geometry.h"
#include "tests/support/lane/mesh.h"

// A lane to measure depth images in: undulating ground; slanted house fronts with windows set back,
// passages under arches and overhanging roofs; fences of pickets, hedges, trees of many small
// leaves with gaps between their boughs; thin poles, signs, cars with curved bodies; gaps between
// houses and a crossing, through which one sees far.

namespace sightline::lane {

struct LaneOptions {
  std::uint64_t seed = 1;
  double length_m = 60.0;
  bool has_leaves = true;  // false: bare trees, no hedges
  double hills = 1.0;      // 0: flat ground, on which the sensor keeps its height
};

// A ball around boughs or a stretch of hedge: what lies in its shadow is seen through leaves.
struct LeafBall {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double radius_m = 1.0;
};

struct Ground {
  double hills = 1.0;
  [[nodiscard]] double height_m(double x_m, double y_m) const;
};

struct Lane {
  Ground ground;
  Mesh mesh;
  std::vector<LeafBall> leaf_balls;
};

Lane make_lane(const LaneOptions& options);

// On the driven line, 2 m above the ground at a length of way, pitching with the ground.
Pose sensor_pose(const Ground& ground, double way_m);

}  // namespace sightline::lane

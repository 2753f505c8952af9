#pragma once

#include "formats/base/random.h"
#include "tests/support/lane/lane.h"
#include "tests/support/lane/mesh.h"

namespace sightline::lane {

struct House {
  double side = 1.0;      // of the lane: +1 or -1 along x
  double from_y_m = 0.0;  // along the lane
  double to_y_m = 10.0;
  double front_m = 6.0;  // from the middle of the lane
  double depth_m = 9.0;
  double storeys = 2.0;
  double slant = 0.0;     // how far the front leans back per metre of height
  bool has_arch = false;  // a passage through the ground floor
};

House draw_house(double side, double from_y_m, Random& random);
void add_house(Mesh& mesh, const House& house, double foot_m);

// A trunk, branches, and where there are leaves boughs of them with gaps between.
void add_tree(Lane& lane, const Eigen::Vector2d& at_m, bool has_leaves, Random& random);

// Along the lane, at one distance from its middle.
struct Border {
  double x_m = 0.0;
  double from_y_m = 0.0;
  double to_y_m = 1.0;
};
void add_hedge(Lane& lane, const Border& border, Random& random);
void add_fence(Lane& lane, const Border& border);

}  // namespace sightline::lane

#pragma once

#include "formats/base/random.h"
#include "tests/support/lane/lane.h"

namespace sightline::lane {

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

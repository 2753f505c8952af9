#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace sightline {

// Coordinates far from 0 in numbers of few digits lie on a lattice: float32 has 0.5 m between
// numbers near 5 400 000, text of six digits 10 m.
struct CoordinateSpacing {
  double spacing_m = 0.0;  // 99 % of different coordinates are so far apart or farther
  double largest_m = 0.0;  // coordinate of that axis
  // Whether this is the distance between two numbers of float32 there, or 1, 10, ... m, and not
  // that of voxels, say.
  [[nodiscard]] bool is_of_numbers() const;
};

// The axis with the wider lattice, x or y; of up to 100 000 points spread over all. Zero where
// there are fewer than 1000 points, where they extend over less than 10 m, or where no coordinate
// is beyond 100 km.
CoordinateSpacing coordinate_spacing(const std::vector<Eigen::Vector3d>& points_m);

}  // namespace sightline

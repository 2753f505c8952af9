#pragma once

#include "formats/surroundings/ndt_map.h"

namespace sightline {

// An ND seen from above: two standard deviations of its points in x and y, map coordinates.
struct NdEllipse {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d long_axis = Eigen::Vector2d::UnitX();  // unit
  double long_radius_m = 0.0;
  double short_radius_m = 0.0;  // 5 cm at least, so that a wall seen edge-on is still a line
};

NdEllipse ellipse_from_above(const Nd& nd);

// A plane (2D) within 45 degrees of level: ground, roofs.
bool is_lying_plane(const Nd& nd);

}  // namespace sightline

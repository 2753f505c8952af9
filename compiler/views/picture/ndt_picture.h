#pragma once

#include <string>

#include "compiler/views/picture/raster.h"
#include "formats/annotation/sites.h"
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

// A rectangle of the map seen from above, map coordinates, x to the right and y up.
struct MapBox {
  double low_x_m = 0.0;
  double low_y_m = 0.0;
  double high_x_m = 0.0;
  double high_y_m = 0.0;

  [[nodiscard]] double width_m() const { return high_x_m - low_x_m; }
  [[nodiscard]] double height_m() const { return high_y_m - low_y_m; }
  [[nodiscard]] bool contains(const Eigen::Vector3d& point_m) const {
    return point_m.x() >= low_x_m && point_m.x() <= high_x_m && point_m.y() >= low_y_m &&
           point_m.y() <= high_y_m;
  }
};

// The least box around all NDs; {0, 0, 0, 0} where there is none.
MapBox box_around(const NdtMap& map);

// NDs as ellipses of two standard deviations, coloured by class: lines (1D) orange, planes (2D)
// blue where they stand and grey where they lie, volumes (3D) green; higher ones over lower ones.
// Sites are black dots. Nothing but NDs with their mean in the box is drawn. 1 unit is 1 m.
std::string ndt_picture_svg(const NdtMap& map, const Sites& sites, const MapBox& box);

// The same in pixels, about 1200 along the longer side. The box must have an extent.
Raster ndt_picture(const NdtMap& map, const Sites& sites, const MapBox& box);

}  // namespace sightline

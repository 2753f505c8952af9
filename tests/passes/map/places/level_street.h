#pragma once

#include <string>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/surroundings/surface.h"

// A level street for tests of sites that are chosen on ground.

namespace sightline {

inline Eigen::AlignedBox2d box(double x0, double y0, double x1, double y1) {
  return {Eigen::Vector2d(x0, y0), Eigen::Vector2d(x1, y1)};
}

inline void add_floor(const Eigen::AlignedBox2d& over_m, double height_m, Surface& surface) {
  for (double x_m = over_m.min().x() + 0.25; x_m < over_m.max().x(); x_m += 0.5) {
    for (double y_m = over_m.min().y() + 0.25; y_m < over_m.max().y(); y_m += 0.5) {
      SurfacePatch patch;
      patch.centre_m = {x_m, y_m, height_m};
      patch.key = cell_key(patch.centre_m, 0.5);
      patch.half_side_m = 0.25;
      surface.patches.push_back(patch);
    }
  }
}

inline Surface level_street() {
  Surface surface;
  surface.frame.origin_world_m = {640.0, 0.0, 0.0};
  surface.cell_m = 0.5;
  surface.tile_m = 64.0;
  add_floor(box(0.0, -5.0, 50.0, 5.0), 0.1, surface);
  return surface;
}

// 1.8 m above ground and 0.5 m ahead of the vehicle's origin, which is on it.
inline SensorProfile sensor_ahead() {
  SensorProfile sensor = *sensor_profile("vlp-16");
  sensor.height_m = 1.8;
  sensor.T_vehicle_lidar.translation() = Eigen::Vector3d(0.5, 0.0, 1.8);
  return sensor;
}

struct ChosenSites {
  Sites sites;
  std::vector<std::string> warnings;
};

}  // namespace sightline

#include "passes/rays/azimuth_view.h"

#include <numbers>

#include "formats/base/portable_math.h"

namespace sightline {

AzimuthView::AzimuthView(const SensorProfile& sensor)
    : is_all_round_(sensor.sees_all_round()),
      least_cosine_(portable_sin_cos(sensor.azimuth_view_deg * std::numbers::pi / 360.0).cos),
      x_in_vehicle_(sensor.T_vehicle_lidar.linear().col(0)) {}

Eigen::Vector2d AzimuthView::forward(const Site& site) const {
  constexpr double kLeastLevel = 1e-3;  // a turn of half a degree about it turns it round
  const Eigen::Matrix3d& R_map_vehicle = site.T_map_vehicle.linear();
  Eigen::Vector2d forward = (R_map_vehicle * x_in_vehicle_).head<2>();
  if (forward.norm() < kLeastLevel) forward = R_map_vehicle.col(0).head<2>();
  return forward.normalized();
}

}  // namespace sightline

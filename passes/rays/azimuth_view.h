#pragma once

#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"

namespace sightline {

// Which directions lie in the azimuth view of a sensor: all, or those within half the view of where
// its +x axis points, both in the plane of the map.
class AzimuthView {
 public:
  AzimuthView() = default;  // all round
  explicit AzimuthView(const SensorProfile& sensor);

  [[nodiscard]] bool is_all_round() const { return is_all_round_; }
  // Where the sensor looks at a site, unit length, map axes: its +x axis, or the vehicle's where
  // that points straight up or down.
  [[nodiscard]] Eigen::Vector2d forward(const Site& site) const;
  [[nodiscard]] bool holds(const Eigen::Vector2d& forward, const Eigen::Vector3d& direction) const {
    const Eigen::Vector2d level = direction.head<2>();
    return is_all_round_ || level.dot(forward) >= least_cosine_ * level.norm();
  }

 private:
  bool is_all_round_ = true;
  double least_cosine_ = -1.0;  // of half the view
  Eigen::Vector3d x_in_vehicle_ = Eigen::Vector3d::UnitX();
};

}  // namespace sightline

#pragma once

#include <array>
#include <cstdint>

#include "formats/reader/reader.h"

// What Autoware's filters before its NDT are set to, from an answer of the map. No ROS here.

namespace sightline_ros2 {

struct FilterOptions {
  // Where the sensor is in the vehicle's frame, the frame of the crop box, m.
  std::array<double, 3> sensor_in_base_m = {0.0, 0.0, 0.0};
  // Autoware's NDT does not match a scan whose farthest point is nearer than required_distance
  // (10 m): the box is never smaller than this, so that some point can be farther.
  double least_range_m = 12.0;
  double min_z_m = -30.0;  // of the box, as Autoware has them
  double max_z_m = 50.0;
  std::int64_t usual_sample_num = 1500;  // where no look says how many points to match
  std::int64_t least_sample_num = 200;
};

struct FilterSettings {
  double min_x_m = 0.0;
  double max_x_m = 0.0;
  double min_y_m = 0.0;
  double max_y_m = 0.0;
  double min_z_m = 0.0;
  double max_z_m = 0.0;
  std::int64_t sample_num = 0;
  friend bool operator==(const FilterSettings&, const FilterSettings&) = default;
};

// Whether the map knows the place and expects the limit to hold there.
inline bool is_trusted(std::uint32_t flags) {
  constexpr std::uint32_t kDoubts = sightline::kAnswerFar | sightline::kAnswerTighterLimit |
                                    sightline::kAnswerUnknownLocalizer |
                                    sightline::kAnswerNotVisible | sightline::kAnswerUnmet;
  return (flags & kDoubts) == 0;
}

// The box holds the ball of the look's range around the sensor. Where the map does not know the
// place, or nothing is good enough there, it is as wide as the map's longest range and the usual
// number of points is matched.
inline FilterSettings settings_for(const sightline::LookAnswer& answer, double longest_range_m,
                                   const FilterOptions& options) {
  const bool is_good = is_trusted(answer.flags);
  const double asked_m = is_good ? answer.look.range_m : longest_range_m;
  const double half_m = asked_m > options.least_range_m ? asked_m : options.least_range_m;
  FilterSettings settings;
  settings.min_x_m = options.sensor_in_base_m[0] - half_m;
  settings.max_x_m = options.sensor_in_base_m[0] + half_m;
  settings.min_y_m = options.sensor_in_base_m[1] - half_m;
  settings.max_y_m = options.sensor_in_base_m[1] + half_m;
  settings.min_z_m = options.min_z_m;
  settings.max_z_m = options.max_z_m;
  settings.sample_num = options.usual_sample_num;
  if (!is_good || answer.look.point_count == 0) return settings;
  const auto points = static_cast<std::int64_t>(answer.look.point_count);
  settings.sample_num = points > options.least_sample_num ? points : options.least_sample_num;
  return settings;
}

// A place of the vehicle's frame in the map's frame: a pose's position and quaternion (x, y, z, w).
inline std::array<double, 3> transformed(const std::array<double, 3>& position_m,
                                         const std::array<double, 4>& q,
                                         const std::array<double, 3>& p_m) {
  // p + 2 w (v x p) + 2 v x (v x p), of a unit quaternion.
  const auto cross = [](const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return std::array<double, 3>{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                                 a[0] * b[1] - a[1] * b[0]};
  };
  const std::array<double, 3> v = {q[0], q[1], q[2]};
  const std::array<double, 3> once = cross(v, p_m);
  const std::array<double, 3> twice = cross(v, once);
  std::array<double, 3> sum_m{};
  for (std::size_t i = 0; i < 3; ++i) {
    sum_m[i] = position_m[i] + p_m[i] + 2.0 * q[3] * once[i] + 2.0 * twice[i];
  }
  return sum_m;
}

}  // namespace sightline_ros2

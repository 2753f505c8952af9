#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace sightline::town {

// An upright rectangle on the ground.
struct Footprint {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0.0;
  double half_length_m = 0.0;
  double half_width_m = 0.0;
};
bool overlaps(const Footprint& a, const Footprint& b);
bool contains(const Footprint& footprint, const Eigen::Vector2d& point_m);

// Height of the uneven ground, m: 3 cm standard deviation, waves of 5 m and more.
double ground_height_m(std::uint64_t seed, const Eigen::Vector2d& point_m);

}  // namespace sightline::town

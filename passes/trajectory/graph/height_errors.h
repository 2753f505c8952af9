#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "formats/geometry.h"
#include "passes/trajectory/following/followed_scans.h"

namespace sightline {

// The heights of scans relative to earlier ones, as accurate as the steps between them.
class HeightErrors {
 public:
  // Steps between consecutive scans (steps_of), of which those to the first scans of pieces are
  // missing; the poses of the scans.
  HeightErrors(std::span<const GraphEdge> steps, std::span<const Pose> T_map_lidar);

  // Standard deviation of the difference of the heights of two scans of one piece, m: each step
  // adds its own error and, by the error of its rotation, as much as the later scan is away.
  [[nodiscard]] double sigma_m(std::size_t earlier, std::size_t later) const;

 private:
  // Sums over the steps up to a scan.
  struct Sums {
    double height_m2 = 0.0;
    double turn_rad2 = 0.0;  // of squares of their standard deviations, ...
    Eigen::Vector2d moment = Eigen::Vector2d::Zero();  // ... times the place behind the step, ...
    double second_moment = 0.0;                        // ... and times its square
  };
  std::vector<Sums> sums_;  // of each scan
  std::vector<Eigen::Vector2d> places_m_;
};

}  // namespace sightline

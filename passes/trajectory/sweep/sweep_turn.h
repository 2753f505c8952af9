#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace sightline {

// How a spinning LiDAR turned during a scan: once round its z axis, from the azimuth where it
// began.
struct SweepTurn {
  double begin_rad = 0.0;
  bool is_clockwise = false;  // seen from above
};

// The turns that may have measured a scan whose file contains ring after ring, each point beside
// the one before it, so that their order does not give their times: from the azimuth where the
// stored rings begin, and from behind (as cameras that look ahead are triggered) in both
// directions. Empty where points are in another order. Points in the sensor's frame, metres.
std::vector<SweepTurn> turns_of_rings(std::span<const Eigen::Vector3d> points_m);

// The time of each point as the share of the scan's time, 0 to 1, by its azimuth.
std::vector<double> turn_times(std::span<const Eigen::Vector3d> points_m, const SweepTurn& turn);

}  // namespace sightline

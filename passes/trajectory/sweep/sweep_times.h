#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace sightline {

// The times of a scan's points by their order alone: a spinning LiDAR that writes points as it
// fires them turns once about its z axis from the first to the last. Of each point the share of the
// scan's time, 0 to 1, by the azimuth that its neighbours in the order reached. Empty where the
// order is another one (ring by ring, sorted, filtered at random), or covers less than 300 or more
// than 450 degrees. Points in the sensor's frame, metres.
std::vector<double> sweep_times(std::span<const Eigen::Vector3d> points_m);

}  // namespace sightline

#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace sightline {

// The ring key of Scan Context (Kim and Kim, IROS 2018), by occupancy in place of height: of each
// ring of 2 m around the sensor, in how many of 60 directions something upright is. It does not
// depend on the heading, and similar places have similar keys: it decides where to search first,
// not where a scan is.
using PlaceKey = std::array<float, 20>;

// From a scan's upright points (scan_overlap.h), in the sensor's frame.
PlaceKey place_key(const std::vector<Eigen::Vector3d>& upright_m);

// Sum over the rings; 0 for equal keys.
double difference(const PlaceKey& a, const PlaceKey& b);

}  // namespace sightline

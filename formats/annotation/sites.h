#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "formats/artifact.h"
#include "formats/geometry.h"
#include "formats/record/fields.h"

namespace sightline {

// A route point that the compiler annotates.
struct Site {
  std::uint32_t run = 0;  // a stretch of route without a gap
  double s_m = 0.0;       // arc length from the start of the run
  Pose T_map_vehicle = Pose::Identity();
  Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();  // the sensor's origin here
};
SIGHTLINE_FIELDS(Site, run, s_m, T_map_vehicle, p_map_m)

struct Sites {
  MapFrame frame;
  double spacing_m = 1.0;
  std::vector<Site> sites;  // ascending by (run, s_m); a site's id is its index
};
SIGHTLINE_FIELDS(Sites, frame, spacing_m, sites)
SIGHTLINE_ARTIFACT(Sites, "sites", 1)

// The sensor's origin at each site, in the map frame.
std::vector<Eigen::Vector3d> positions_m(const Sites& sites);

// Length of all runs together.
double route_length_m(const Sites& sites);

// Degrees between a line of this heading (from map +x, either way along it) and the way the vehicle
// points at the site, in the plane: 0 to 90.
double off_road_deg(const Site& site, double heading_deg);
// "along the road" below 30 degrees, "across the road" above 60, "aslant" between.
std::string_view name_of_way(double off_road_deg);

Result<void> validate(const Sites& sites);
Table dump(const Sites& sites);

}  // namespace sightline

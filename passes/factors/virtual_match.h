#pragma once

#include <span>

#include "formats/geometry.h"
#include "passes/matching/localizer.h"

// The virtual scan localized as a vehicle would its own (schemas/definitions.md, "Factors from a
// virtual scan"): what bounds around the right pose cannot tell, another optimum down the street.

namespace sightline {

// Where and how a virtual scan is localized.
struct VirtualPlace {
  Eigen::Vector3d p_map_m;
  Eigen::Matrix3d R_map_vehicle;              // starts are laid out along the vehicle
  std::span<const Eigen::Vector3d> points_m;  // within the range, from p, map axes
  double loose_heading_deg = 0.0;             // crlb_heading
};

struct VirtualMatch {
  // Mean distance from p over the starts of "Measured error", which see four views, a quarter of
  // the azimuths hidden in each.
  double error_m = 0.0;
  // The best score 0.5 to 2.5 m off along the loose direction, over that at p, of points that lead.
  double rival_score = 1.0;
};
VirtualMatch virtual_match(const Localizer& localizer, const VirtualPlace& place);

}  // namespace sightline

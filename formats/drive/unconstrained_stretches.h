#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/drive/trajectory.h"
#include "formats/drive/unconstrained.h"
#include "formats/record/fields.h"

// Where scans do not constrain the motion of the vehicle that recorded them ("Unconstrained poses"
// in schemas/definitions.md, v1).

namespace sightline {

// Scans in a row whose poses are unconstrained in the same directions.
struct UnconstrainedStretch {
  std::uint32_t first_scan = 0;  // recording index
  std::uint32_t last_scan = 0;
  double way_m = 0.0;  // up to the last scan, from the scan before the first
  Unconstrained directions = {};
  // Standard deviation of the last position in these directions, relative to the scan before the
  // first; none where it is not known: given poses, or no substitute.
  std::optional<double> sigma_m = std::nullopt;
  Eigen::Vector3d begin_map_m = Eigen::Vector3d::Zero();  // of the vehicle at these scans
  Eigen::Vector3d end_map_m = Eigen::Vector3d::Zero();

  // Whether the poses rest on a speed that was not measured.
  [[nodiscard]] bool is_assumed() const;
  friend bool operator==(const UnconstrainedStretch&, const UnconstrainedStretch&) = default;
};
SIGHTLINE_FIELDS(UnconstrainedStretch, first_scan, last_scan, way_m, directions, sigma_m,
                 begin_map_m, end_map_m)

// In the order of the scans.
std::vector<UnconstrainedStretch> unconstrained_stretches(const Trajectory& trajectory);
// sigma_m of the stretch up to each pose; none where that is not known, and outside of stretches.
std::vector<std::optional<double>> unconstrained_sigmas_m(const Trajectory& trajectory);

// "along the road, in heading".
std::string directions_text(const Unconstrained& directions);
// "constant speed is assumed, +/- 1.8 m".
std::string substitute_text(const UnconstrainedStretch& stretch);
// "scans 3 to 40: 36.2 m of the way are not constrained along the road; constant speed ...".
std::string to_text(const UnconstrainedStretch& stretch);

}  // namespace sightline

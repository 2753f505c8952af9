#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "formats/surroundings/sharpness.h"

namespace sightline {

struct MeasureSharpnessOptions {
  double radius_m = 0.5;     // around a point, for entropy
  double cell_m = 2.0;       // of the NDs whose thickness is judged
  double scan_step_m = 2.0;  // of the way between the scans that are laid on each other
  double reach_m = 30.0;     // returns farther from the sensor take no part
};
// Which points are judged; others are there for their sake.
using IsOwn = std::function<bool(const Eigen::Vector3d& point_m)>;

// Sums over points, of which figures of any set of tiles are made.
struct SharpnessSums {
  double entropy_nat = 0.0;
  std::uint64_t entropy_points = 0;
  double plane_variance_m2 = 0.0;
  std::uint64_t plane_points = 0;
};
SIGHTLINE_FIELDS(SharpnessSums, entropy_nat, entropy_points, plane_variance_m2, plane_points)

// Of points that are laid already.
SharpnessSums sharpness_sums(const std::vector<Eigen::Vector3d>& points_m, const IsOwn& is_own,
                             const MeasureSharpnessOptions& options, int threads);
SharpnessFigures figures_of(const std::vector<SharpnessSums>& all);

// Of all points; their order decides nothing but last bits, threads nothing.
SharpnessFigures sharpness_of(const std::vector<Eigen::Vector3d>& points_m,
                              const MeasureSharpnessOptions& options, int threads);

}  // namespace sightline

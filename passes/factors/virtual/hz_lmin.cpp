#include "passes/factors/virtual/hz_lmin.h"

#include <algorithm>

#include "formats/base/portable_math.h"

namespace sightline {

double hz_lmin(const Eigen::Matrix2d& planar_normals) {
  const double half_sum = 0.5 * (planar_normals(0, 0) + planar_normals(1, 1));
  const double half_difference = 0.5 * (planar_normals(0, 0) - planar_normals(1, 1));
  return std::max(0.0, half_sum - portable_hypot(half_difference, planar_normals(0, 1)));
}

}  // namespace sightline

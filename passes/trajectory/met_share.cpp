#include "passes/trajectory/met_share.h"

#include <algorithm>
#include <cmath>

#include "passes/matching/covariance/structure.h"

namespace sightline {
namespace {

// A return meets a surface this near to its plane, within so many of its standard deviations.
constexpr double kMeets_m = 0.25;
constexpr double kMeetsSigmas = 3.0;
// A wall's normal is level within 30 degrees.
constexpr double kUprightNormal = 0.5;
constexpr std::size_t kFewestMet = 30;

}  // namespace

bool identifies_place(const Nd& nd) {
  return (is_surface(nd) && std::abs(nd.eigenvectors(2, 2)) < kUprightNormal) ||
         is_upright_line(nd);
}

NdsByCell::NdsByCell(const NdtMap& map) : cell_m_(map.cell_m) {
  for (const Nd& nd : map.nds) cells_.insert(nd.key, &nd);
}

bool meets(const Nd& nd, const Eigen::Vector3d& point_map_m) {
  const Eigen::Vector3d along_m = nd.eigenvectors.transpose() * (point_map_m - nd.mean_m);
  for (int axis = 0; axis < 3; ++axis) {
    const double sigma_m = std::sqrt(nd.eigenvalues_m2[axis]);
    if (std::abs(along_m[axis]) > std::max(kMeetsSigmas * sigma_m, kMeets_m)) return false;
  }
  return std::abs(along_m[2]) <= kMeets_m;
}

std::optional<double> met_share(const NdsByCell& nds, std::span<const Eigen::Vector3d> upright_m,
                                const Pose& T_map_points) {
  std::size_t met = 0;
  std::size_t missed = 0;
  for (const Eigen::Vector3d& point_m : upright_m) {
    const Eigen::Vector3d point_map_m = T_map_points * point_m;
    bool is_met = false;
    bool is_unclear = false;
    nds.visit_near(point_map_m, [&](const Nd& nd) {
      const bool is_near = meets(nd, point_map_m);
      is_met = is_met || (is_near && identifies_place(nd));
      is_unclear = is_unclear || (is_near && !identifies_place(nd));
    });
    met += is_met ? 1 : 0;
    missed += !is_met && !is_unclear ? 1 : 0;
  }
  if (met + missed < kFewestMet) return std::nullopt;
  return static_cast<double>(met) / static_cast<double>(met + missed);
}

}  // namespace sightline

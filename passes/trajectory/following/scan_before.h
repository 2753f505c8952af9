#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "formats/geometry.h"
#include "passes/trajectory/local/local_map.h"

namespace sightline {

// The scan before one that is followed, to compare a step by these two scans alone. Scans that were
// placed wrongly are part of the local map, and the next ones meet them: of a drive that seems to
// stand still the overlap with its local map is 0.85, that of two scans in a row 0.3.
class ScanBefore {
 public:
  // Upright points (upright_points), the denser ones of the scan.
  void set(const std::vector<Eigen::Vector3d>& upright_m, const Pose& T_map_lidar);

  // Share of the points that meet that scan (UprightMap::overlap).
  [[nodiscard]] std::optional<double> overlap(const std::vector<Eigen::Vector3d>& upright_m,
                                              const Pose& T_map_lidar) const;

  // How far ahead of a pose, along a direction of length 1, the two scans clearly overlap more, at
  // most 25 m to either side; none where they do nowhere, or overlap by a half at this pose. Such a
  // place is 3 m away or more, and the vehicle moved 3 m or more to it, at most `farthest_m`: rings
  // and vehicles that drive along overlap as if it stood.
  [[nodiscard]] std::optional<double> rival_m(const std::vector<Eigen::Vector3d>& upright_m,
                                              const Pose& T_map_lidar, const Eigen::Vector3d& ahead,
                                              double farthest_m) const;

 private:
  UprightMap upright_{1.0};
  Eigen::Vector3d at_map_m_ = Eigen::Vector3d::Zero();
};

}  // namespace sightline

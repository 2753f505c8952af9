#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "formats/geometry.h"
#include "passes/trajectory/local/local_map.h"
#include "passes/trajectory/local/met_surfaces.h"
#include "passes/trajectory/local/scan_constraint.h"

// Placing a scan where few surfaces hold it; part of estimate-trajectory.

namespace sightline {

// Where a fit begins: at the pose that a forecast predicts.
struct FitStart {
  Pose T_map_lidar = Pose::Identity();
  std::vector<PlanarMotion> weak_motions;       // of length 1, orthogonal
  PlanarMotion sigma_m = PlanarMotion::Zero();  // of the forecast; its errors are independent
};

// Point to plane by Gauss-Newton from the forecast ("Constraints of a match" in
// schemas/definitions.md, v2): the pose of the sensor. A surface is used for a weak motion only if
// it clearly holds it; the forecast is one more observation of these motions. All surfaces are used
// for the other motions.
Pose fit_structure(std::span<const RollingCells* const> grids,
                   const std::vector<Eigen::Vector3d>& points_m, const FitStart& start,
                   const Pose& T_lidar_vehicle);

}  // namespace sightline

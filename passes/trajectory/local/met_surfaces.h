#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "formats/geometry.h"
#include "passes/matching/covariance/structure_information.h"
#include "passes/trajectory/local/local_map.h"

// The surfaces of a local map that a scan meets, and which motions each observes; part of
// estimate-trajectory.

namespace sightline {

// A PlanarMotion, then up, m, and roll and pitch, rad; about the vehicle, in its axes with z up.
using LevelMotion = Vector6d;

// A cell of the map along one axis of its ND. Its distance is that of the scan's points in it from
// the ND along this axis, on average.
struct MetSurface {
  double distance_m = 0.0;
  double weight_per_m2 = 0.0;                   // 1 / variance of the distance
  LevelMotion by_motion = LevelMotion::Zero();  // derivative of the distance by a motion
  Eigen::Matrix3d axis_covariance = Eigen::Matrix3d::Zero();  // in the vehicle's axes
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();            // from the vehicle to these points

  double deviation_m = 0.0;  // of the map's points along the axis
  bool is_lasting = true;    // RollingCells::is_lasting

  // How much of a planar motion of length 1 is along the axis.
  [[nodiscard]] double part(const PlanarMotion& motion) const {
    return by_motion.head<3>().dot(motion);
  }
  // Whether it is more than errors of poses leave of a surface along the motion: 10 degrees.
  [[nodiscard]] bool holds(const PlanarMotion& motion) const;
  // Whether it is also more than an axis of noisy returns has by chance, and of a thin surface that
  // was there for some time.
  [[nodiscard]] bool clearly_holds(const PlanarMotion& motion) const;
};

// A pose after a small motion.
Pose moved_level(const Pose& T_map_vehicle, const LevelMotion& motion);

// Of the cells that hold points of the scan: surfaces along their normal, upright lines (poles and
// trunks) along both axes across them. Points that meet a surface of the first of `grids` are not
// sought in the next. `points_m` in the sensor's frame; map z is up.
std::vector<MetSurface> met_surfaces(std::span<const RollingCells* const> grids,
                                     const std::vector<Eigen::Vector3d>& points_m,
                                     const Pose& T_map_lidar, const Pose& T_lidar_vehicle);
std::vector<MetSurface> met_surfaces(const LocalGrids& grids,
                                     const std::vector<Eigen::Vector3d>& points_m,
                                     const Pose& T_map_lidar, const Pose& T_lidar_vehicle);

}  // namespace sightline

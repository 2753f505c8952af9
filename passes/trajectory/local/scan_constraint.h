#pragma once

#include <Eigen/Core>
#include <vector>

#include "formats/geometry.h"
#include "passes/trajectory/local/met_surfaces.h"

// Which motions of a scan in the plane a local map constrains; part of estimate-trajectory.

namespace sightline {

// Three orthogonal motions, columns of length 1, the least constrained first, and the standard
// deviation of a match in each ("Constraints of a match" in schemas/definitions.md, v2).
struct ScanConstraint {
  Eigen::Matrix3d motions = Eigen::Matrix3d::Identity();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();

  // Weak: where the standard deviation exceeds `most_m`.
  [[nodiscard]] bool has_weak(double most_m) const { return sigma_m[0] > most_m; }
  // By axis, forward, left and turn: how much of it is weak, 0 to 1.
  [[nodiscard]] Eigen::Vector3d weak_axes(double most_m) const;
  // The weak motions.
  [[nodiscard]] std::vector<PlanarMotion> weak_motions(double most_m) const;
  // Projects a motion onto its weak part.
  [[nodiscard]] Eigen::Matrix3d weak_part(double most_m) const;
};

// Above 2 cm matches are off by up to metres, where rings meet rings; in streets it is 2 to 6 mm.
// From 1 cm on they are off by centimetres, like a speed assumed to be constant and unlike a given
// step.
inline constexpr double kWeakBesideGiven_m = 0.01;
inline constexpr double kWeak_m = 0.02;
// From here on few surfaces hold a scan: overlaps and wide searches are no evidence.
inline constexpr double kSparse_m = 0.0075;

// Which surfaces count for a motion: those that hold it, or that clearly do (MetSurface).
enum class HoldRule { kAll, kClear };

// By axis, forward, left and turn: the share of an error of a start that a match with such a
// constraint leaves, 0 to 1: variance / (variance + (0.1 m)^2), with 0.3 m instead to the left and
// in turn.
Eigen::Vector3d kept_shares(const ScanConstraint& constraint);

// By the surfaces that a scan meets at its pose (met_surfaces). A surface constrains motions along
// its normal, an upright line those across it. Rings on the ground and along walls, ends of cells,
// and motions that a normal is within 10 degrees, or three standard deviations of its own, of being
// square to count as nothing: a vehicle that stands and one that slides measure the same rings. One
// observation a cell; height, roll and pitch are eliminated.
ScanConstraint scan_constraint(const std::vector<MetSurface>& surfaces,
                               HoldRule rule = HoldRule::kAll);

// The motion in the plane from one pose of the vehicle to another one near it, and the pose after
// such a motion. Height, roll and pitch stay.
PlanarMotion planar_motion(const Pose& T_map_from, const Pose& T_map_to);
Pose moved_in_plane(const Pose& T_map_vehicle, const PlanarMotion& motion);

}  // namespace sightline

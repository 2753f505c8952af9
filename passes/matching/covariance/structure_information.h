#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/geometry.h"
#include "passes/matching/covariance/structure.h"
#include "passes/matching/kernel_score.h"
#include "passes/matching/match_score.h"

// What a scan and a map constrain of a pose, whatever the start: the information of planes and
// lines (Censi, "An accurate closed-form estimate of ICP's covariance", ICRA 2007; Tuna et al.,
// "X-ICP", T-RO 2023, from which the limit on small components of normals comes).

namespace sightline {

// A small motion in the plane, in the vehicle's axes: forward and left, m, and the turn about the
// vehicle times kTurnArm_m, m. A turn then counts as what it moves surfaces at that distance.
using PlanarMotion = Eigen::Vector3d;
inline constexpr double kTurnArm_m = 10.0;

// Noise of a return.
inline constexpr double kReturnNoise_m = 0.02;
// A normal's component below this along a motion is noise: sin(10 degrees).
inline constexpr double kLeastComponent = 0.17;
// Standard deviations of height, roll and pitch without any surface.
inline constexpr double kFreeHeight_m = 1.0;
inline constexpr double kFreeTilt_rad = 0.1;

// The vehicle's axes, level: rows forward, left, up of the map's.
Eigen::Matrix3d level_axes(const Pose& T_map_vehicle);

// One observation: how far the points of a cell are from its surface or line, in one direction, and
// its derivative by a motion (forward, left, up; turns about these).
struct StructureObservation {
  Vector6d by_motion = Vector6d::Zero();
  double arm_m = 0.0;  // length of the derivative by turns
  double residual_m = 0.0;
  double weight_per_m2 = 0.0;
};

// The points of a scan that are in no cell of the map with a horizontal surface, and of these the
// ones that the map has: on the structure of their cell, or in a cell whose ND constrains nothing.
struct RaisedPoints {
  std::uint32_t count = 0;
  std::uint32_t met_count = 0;
};

// Observes a scan: one observation for each direction of each structure that its points meet. Keeps
// its memory from one scan to the next. One thread at a time.
class StructureObserver {
 public:
  // For points of a vehicle at that pose; forgets the last scan. `map` outlives that.
  void begin(const StructureMap& map, const Pose& T_map_vehicle);

  // A point of the cell with that structure. Whether it is on the structure; else it is left out.
  bool add(std::uint32_t structure, const Eigen::Vector3d& point_map_m);

  // At most 512 points of a scan, in the vehicle's frame, evenly spread in their order: more would
  // count neighbours as independent. Those in no structure of the map are left out. They must be
  // within 2^31 cells of the origin. Where the scan was matched in the map's grid, its cells are
  // taken over.
  void add_all(const ScanForMatch& scan, const Pose& T_map_vehicle);

  // In the order in which the structures were met. Valid until the next scan begins.
  std::span<const StructureObservation> finish();

  [[nodiscard]] const Eigen::Matrix3d& axes() const { return axes_; }
  // Of those that add_all() used.
  [[nodiscard]] const RaisedPoints& raised() const { return raised_; }

 private:
  // The points of a scan that meet one structure.
  struct Met {
    std::uint32_t structure = 0;
    double count = 0.0;
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();  // from the vehicle, map axes
  };
  void find_records(const ScanForMatch& scan, const Pose& T_map_vehicle);
  void add_point(std::uint32_t number, const Eigen::Vector3d& point_map_m);
  void observe(const Met& met, const Eigen::Vector3d& direction, double variance_m2);

  const StructureMap* map_ = nullptr;
  Eigen::Matrix3d axes_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre_map_m_ = Eigen::Vector3d::Zero();
  std::vector<Met> met_;
  RaisedPoints raised_;
  // By structure: its place in met_, if that has this structure.
  std::vector<std::uint32_t> place_of_;
  std::vector<StructureObservation> observations_;
  // Of the points that are added at once.
  std::vector<Eigen::Vector3d> points_map_m_;
  std::vector<std::int32_t> records_;
  std::vector<std::uint32_t> numbers_;
};

// What the observations of a scan are in sum. Map axes; order dx dy dz wx wy wz about the vehicle's
// origin, as MatchScore's derivatives.
struct StructureEvidence {
  // Of all six motions. Along each eigenvector of that of motions in the plane (height, roll and
  // pitch eliminated) it is at most that of the observations that clearly have a part of the
  // motion. Never below 0, singular where nothing constrains a motion.
  Matrix6d information = Matrix6d::Zero();
  // Minus the gradient of half the weighted sum of squared residuals, reduced in the same way.
  Vector6d descent = Vector6d::Zero();
  // Whether the observations, clear or not, have a part of every motion; false: some motion changes
  // none of them, apart from rounding.
  bool holds_every_motion = false;
  RaisedPoints raised;
};
StructureEvidence structure_evidence(std::span<const StructureObservation> observations,
                                     const Eigen::Matrix3d& level_axes);

// Of a scan, in the vehicle's frame, and where it was matched. Allocates nothing once such scans
// were seen.
StructureEvidence structure_evidence(const StructureMap& map, const ScanForMatch& scan,
                                     const Pose& T_map_vehicle, StructureObserver& memory);

}  // namespace sightline

#include "passes/trajectory/local/structure_fit.h"

#include <Eigen/Cholesky>
#include <cmath>

// A likelihood over all returns is best where the rings of a scan meet those of the last scans:
// each match in a tunnel is some centimetres short. Here rings do not take part. Normals are
// estimated from noisy returns, and along a tunnel that noise is all that hundreds of walls have:
// only surfaces with more than that measure the way (Censi, ICRA 2007; Zhang, Kaess, Singh, "On
// degeneracy of optimization-based state estimation problems", ICRA 2016: solve the weak directions
// from the prediction).

namespace sightline {
namespace {

constexpr int kMostSteps = 8;
constexpr double kLastStep_m = 2e-4;
// Distances larger than this count less (Cauchy).
constexpr double kRobust_m = 0.1;

struct Equations {
  Matrix6d information = Matrix6d::Zero();
  LevelMotion gradient = LevelMotion::Zero();

  void add(const LevelMotion& by_motion, double distance_m, double weight_per_m2) {
    information += weight_per_m2 * by_motion * by_motion.transpose();
    gradient += weight_per_m2 * distance_m * by_motion;
  }
};

// Without the parts along weak motions that it does not clearly hold.
LevelMotion clear_part(const MetSurface& surface, const std::vector<PlanarMotion>& weak) {
  LevelMotion by_motion = surface.by_motion;
  for (const PlanarMotion& motion : weak) {
    if (!surface.clearly_holds(motion)) by_motion.head<3>() -= surface.part(motion) * motion;
  }
  return by_motion;
}

// Of the forecast, after the scan was moved from it.
void add_forecast(const FitStart& start, const LevelMotion& moved, Equations& equations) {
  for (const PlanarMotion& motion : start.weak_motions) {
    LevelMotion by_motion = LevelMotion::Zero();
    by_motion.head<3>() = motion;
    const double variance_m2 = motion.cwiseProduct(start.sigma_m).squaredNorm();
    equations.add(by_motion, by_motion.dot(moved), 1.0 / variance_m2);
  }
  const double sigmas[] = {kFreeHeight_m, kFreeTilt_rad, kFreeTilt_rad};
  for (int i = 0; i < 3; ++i) {
    const LevelMotion by_motion = LevelMotion::Unit(3 + i);
    equations.add(by_motion, moved[3 + i], 1.0 / (sigmas[i] * sigmas[i]));
  }
}

}  // namespace

Pose fit_structure(std::span<const RollingCells* const> grids,
                   const std::vector<Eigen::Vector3d>& points_m, const FitStart& start,
                   const Pose& T_lidar_vehicle) {
  const Pose T_vehicle_lidar = T_lidar_vehicle.inverse();
  Pose T_map_vehicle = start.T_map_lidar * T_lidar_vehicle;
  LevelMotion moved = LevelMotion::Zero();
  for (int step = 0; step < kMostSteps; ++step) {
    Equations equations;
    for (const MetSurface& surface :
         met_surfaces(grids, points_m, T_map_vehicle * T_vehicle_lidar, T_lidar_vehicle)) {
      const double share = surface.distance_m / kRobust_m;
      equations.add(clear_part(surface, start.weak_motions), surface.distance_m,
                    surface.weight_per_m2 / (1.0 + share * share));
    }
    add_forecast(start, moved, equations);
    const LevelMotion by = -equations.information.ldlt().solve(equations.gradient);
    if (!by.allFinite()) break;
    moved += by;
    T_map_vehicle = moved_level(T_map_vehicle, by);
    if (by.norm() < kLastStep_m) break;
  }
  return T_map_vehicle * T_vehicle_lidar;
}

}  // namespace sightline

#include "examples/town/drive/constraint.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace sightline::town {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kEvery = 4;         // of the azimuth steps, another one for each ring
constexpr double kReach_m = 1.0;  // from a point to its surface
constexpr double kStart_m = 0.3;
constexpr double kLever_m = 10.0;  // turns count as metres at that distance

// In the vehicle's frame, as the sensor would measure them at the true pose.
std::vector<Eigen::Vector3d> exact_points(const DriveSimulator& drive, const Pose& T_town_vehicle) {
  const SensorProfile& sensor = drive.sensor();
  const Pose T_town_lidar = T_town_vehicle * sensor.T_vehicle_lidar;
  std::vector<Eigen::Vector3d> points_m;
  int ring = 0;
  for (const double elevation_deg : sensor.beam_elevations_deg) {
    for (int step = ++ring % kEvery; step < sensor.azimuth_count(); step += kEvery) {
      const Eigen::Vector3d ray =
          direction_of(to_radians(sensor.azimuth_deg(step)), to_radians(elevation_deg));
      const double range_m =
          drive.standing().exact_range_m(T_town_lidar.translation(), T_town_lidar.linear() * ray);
      if (range_m > sensor.max_range_m || range_m < sensor.min_range_m) continue;
      points_m.push_back(sensor.T_vehicle_lidar * (range_m * ray));
    }
  }
  return points_m;
}

// Normal equations of point to plane; a correction is a shift and a turn about the vehicle, both
// in its axes, the turn in units of 1 / kLever_m.
struct Equations {
  Matrix6 information = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
};

Equations equations_at(const TownCaster& world, const std::vector<Eigen::Vector3d>& points_m,
                       const Pose& T_town_vehicle) {
  constexpr double kRobust_m = 0.2;
  Equations equations;
  for (const Eigen::Vector3d& point_m : points_m) {
    const Eigen::Vector3d at_m = T_town_vehicle * point_m;
    const Surface surface = world.nearest_surface(at_m, kReach_m);
    if (!surface.is_found) continue;
    const double residual_m = surface.normal.dot(at_m - surface.point_m);
    const Eigen::Vector3d normal = T_town_vehicle.linear().transpose() * surface.normal;
    Vector6 row;
    row << normal, point_m.cross(normal) / kLever_m;
    const double weight = 1.0 / (1.0 + residual_m * residual_m / (kRobust_m * kRobust_m));
    equations.information += weight * row * row.transpose();
    equations.gradient += weight * residual_m * row;
  }
  return equations;
}

// Where a match from the start ends. A small part of the greatest information is added to every
// direction, so that rounding and the facets of a bend constrain nothing.
Pose match(const TownCaster& world, const std::vector<Eigen::Vector3d>& points_m, Pose T) {
  constexpr int kSteps = 8;
  constexpr double kDamping = 1e-3;
  for (int step = 0; step < kSteps; ++step) {
    Equations equations = equations_at(world, points_m, T);
    const double damping = kDamping * (equations.information.diagonal().maxCoeff() + 1e-9);
    equations.information.diagonal().array() += damping;
    const Vector6 by = equations.information.ldlt().solve(-equations.gradient);
    const Eigen::Vector3d turn_rad = by.tail<3>() / kLever_m;
    Pose correction = Pose::Identity();
    correction.translation() = by.head<3>();
    const double angle_rad = turn_rad.norm();
    if (angle_rad > 0.0) correction.linear() = rotation_matrix({turn_rad / angle_rad, angle_rad});
    T = T * correction;
  }
  return T;
}

double kept_share(const TownCaster& world, const std::vector<Eigen::Vector3d>& points_m,
                  const Pose& truth, int axis) {
  const auto end_m = [&](double start_m) {
    Pose start = truth;
    start.translation() += start_m * truth.linear().col(axis);
    const Pose end = match(world, points_m, start);
    return truth.linear().col(axis).dot(end.translation() - truth.translation());
  };
  const double ahead_m = end_m(kStart_m);
  const double behind_m = end_m(-kStart_m);
  return (ahead_m - behind_m) / (2.0 * kStart_m);
}

}  // namespace

Constraint constraint_of(const DriveSimulator& drive, std::size_t index) {
  constexpr double kNoise_m = 0.02;
  constexpr double kMost_m = 99.0;
  const TownCaster& world = drive.standing();
  const Pose truth = drive.T_town_vehicle()[index];
  const std::vector<Eigen::Vector3d> points_m = exact_points(drive, truth);
  const Matrix6 information =
      kEvery * equations_at(world, points_m, truth).information / (kNoise_m * kNoise_m);
  const Matrix6 prior = Matrix6::Identity() / (kMost_m * kMost_m);
  const Matrix6 covariance = (information + prior).ldlt().solve(Matrix6::Identity());
  Constraint constraint;
  constraint.kept_ahead = kept_share(world, points_m, truth, 0);
  constraint.kept_left = kept_share(world, points_m, truth, 1);
  constraint.sigma_ahead_m = std::min(kMost_m, std::sqrt(std::max(0.0, covariance(0, 0))));
  constraint.sigma_left_m = std::min(kMost_m, std::sqrt(std::max(0.0, covariance(1, 1))));
  return constraint;
}

}  // namespace sightline::town

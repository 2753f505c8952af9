#include "tests/bench/integrity/closed_loop.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <optional>

#include "formats/base/random.h"
#include "formats/symmetric_eigen.h"
#include "tests/bench/bench_tools.h"

namespace sightline {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr double kWheelsOff = 0.02;
constexpr double kGyroOff_rad_per_s = 0.02 * kRadPerDeg;
constexpr double kWheelNoise_m = 0.01;                // in a step
constexpr double kGyroNoise_rad = 0.03 * kRadPerDeg;  // in a step
constexpr double kStep_s = 0.1;
constexpr double kHeightOff_m = 0.03;  // of starts
constexpr double kStartTurn_rad = 0.5 * kRadPerDeg;
constexpr double kStartDeviations[] = {0.141,          0.141,          0.05,
                                       kStartTurn_rad, kStartTurn_rad, kStartTurn_rad};

PlanarPose planar_pose(const Pose& pose) {
  return {pose.translation().x(), pose.translation().y(),
          std::atan2(pose.linear()(1, 0), pose.linear()(0, 0))};
}

// Rows: forward, left, yaw.
Eigen::Matrix3d axes_at(double yaw_rad) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  axes.topLeftCorner<2, 2>() << std::cos(yaw_rad), std::sin(yaw_rad), -std::sin(yaw_rad),
      std::cos(yaw_rad);
  return axes;
}

// The true pose, moved in the plane to where the vehicle takes itself to be.
Pose start_at(const PlanarPose& pose, const Pose& T_map_true, double up_m) {
  const double turn_rad = pose.z() - planar_pose(T_map_true).z();
  Pose start = T_map_true;
  start.linear() =
      Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix() * start.linear();
  start.translation() = Eigen::Vector3d(pose.x(), pose.y(), start.translation().z() + up_m);
  return start;
}

// Of x, y, yaw, all other motions free to follow.
Eigen::Matrix3d planar_part(const Matrix6d& information) {
  constexpr int kOrder[] = {0, 1, 5, 2, 3, 4};
  Matrix6d ordered;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) ordered(i, j) = information(kOrder[i], kOrder[j]);
  }
  Eigen::Matrix3d others = ordered.bottomRightCorner<3, 3>();
  others.diagonal().array() += 1e-3;
  const Eigen::Matrix3d both = ordered.bottomLeftCorner<3, 3>();
  return ordered.topLeftCorner<3, 3>() - both.transpose() * others.inverse() * both;
}

Matrix6d start_covariance(const Eigen::Matrix3d& planar) {
  constexpr int kOrder[] = {0, 1, 5};
  Matrix6d start = Matrix6d::Zero();
  start.diagonal() << 0.0, 0.0, kHeightOff_m * kHeightOff_m, 1e-6, 1e-6, 0.0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) start(kOrder[i], kOrder[j]) = planar(i, j);
  }
  return start;
}

Eigen::Matrix3d planar_block(const Matrix6d& covariance) {
  constexpr int kOrder[] = {0, 1, 5};
  Eigen::Matrix3d block;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) block(i, j) = covariance(kOrder[i], kOrder[j]);
  }
  return block;
}

// Autoware's estimate_xy_covariance_by_multi_ndt with its default offsets, turned to the Hessian's
// principal axes, and no smaller than the fixed one in the vehicle's axes.
Eigen::Matrix3d multi_ndt_covariance(WorldLocalizer& localizer, const MatchResult& found) {
  constexpr double kAhead_m[] = {0.0, 0.0, 0.5, -0.5, 1.0, -1.0};
  constexpr double kAside_m[] = {0.5, -0.5, 0.0, 0.0, 0.0, 0.0};
  Eigen::Matrix2d turned = Eigen::Matrix2d::Identity();
  if (const std::optional<Matrix6d> laplace = covariance_of(found)) {
    const SymmetricEigen<2> eigen = symmetric_eigen<2>(laplace->topLeftCorner<2, 2>());
    turned << eigen.vectors(0, 1), -eigen.vectors(1, 1), eigen.vectors(1, 1), eigen.vectors(0, 1);
  }
  std::vector<Eigen::Vector2d> ends_m = {found.T_map_sensor.translation().head<2>()};
  for (std::size_t i = 0; i < std::size(kAhead_m); ++i) {
    Pose start = found.T_map_sensor;
    start.translation().head<2>() += turned * Eigen::Vector2d(kAhead_m[i], kAside_m[i]);
    ends_m.emplace_back(localizer.match(start).T_map_sensor.translation().head<2>());
  }
  Eigen::Vector2d mean_m = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& end_m : ends_m) {
    mean_m += end_m / static_cast<double>(ends_m.size());
  }
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& end_m : ends_m) {
    const Eigen::Vector2d off_m = end_m - mean_m;
    spread += off_m * off_m.transpose() / static_cast<double>(ends_m.size() - 1);
  }
  const double yaw_rad = planar_pose(found.T_map_sensor).z();
  const Eigen::Matrix2d axes = axes_at(yaw_rad).topLeftCorner<2, 2>();
  Eigen::Matrix2d in_vehicle = axes * spread * axes.transpose();
  for (int i = 0; i < 2; ++i) in_vehicle(i, i) = std::max(in_vehicle(i, i), 0.0225);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  covariance.topLeftCorner<2, 2>() = axes.transpose() * in_vehicle * axes;
  covariance(2, 2) = 0.000625;
  return covariance;
}

struct Sensors {
  Random random;
  double wheel_scale = 0.0;
  double gyro_bias_rad_per_s = 0.0;

  WheelsAndGyro between(const Pose& before, const Pose& after) {
    const PlanarPose from = planar_pose(before);
    const PlanarPose to = planar_pose(after);
    const double way_m = (to - from).head<2>().norm();
    WheelsAndGyro measured;
    measured.seconds = kStep_s;
    measured.speed_m_per_s =
        ((1.0 + wheel_scale) * way_m + kWheelNoise_m * random.normal()) / kStep_s;
    measured.turn_rad_per_s =
        (wrapped_rad(to.z() - from.z()) + kGyroNoise_rad * random.normal()) / kStep_s +
        gyro_bias_rad_per_s;
    return measured;
  }
};

Sensors sensors_of(std::uint64_t seed) {
  Sensors sensors{Random(mix(seed, 57)), 0.0, 0.0};
  sensors.wheel_scale = sensors.random.uniform() < 0.5 ? kWheelsOff : -kWheelsOff;
  sensors.gyro_bias_rad_per_s =
      sensors.random.uniform() < 0.5 ? kGyroOff_rad_per_s : -kGyroOff_rad_per_s;
  return sensors;
}

// Of a vehicle that tracks.
KnownStart tracking_start(const Pose& T_map_true, Random& random) {
  Vector6d off;
  for (int i = 0; i < 6; ++i) {
    const bool is_level = i == 3 || i == 4;
    off[i] = (is_level ? 0.0 : kStartDeviations[i]) * random.normal();
  }
  return {moved(T_map_true, off), tracking_start_covariance()};
}

KnownStart start_of_filter(const PoseFilter& filter, const Pose& T_map_true, Random& random) {
  return {start_at(filter.pose(), T_map_true, kHeightOff_m * random.normal()),
          start_covariance(filter.covariance())};
}

// From map axes to the vehicle's.
Matrix6d six_axes(const Pose& T_map_true) {
  Matrix6d axes = Matrix6d::Zero();
  axes.topLeftCorner<3, 3>() = T_map_true.linear().transpose();
  axes.bottomRightCorner<3, 3>() = T_map_true.linear().transpose();
  return axes;
}

MatchSample sample_of(const MatchResult& found, const Pose& T_map_start, const Pose& T_map_true,
                      const StructureEvidence& structure) {
  const Matrix6d axes = six_axes(T_map_true);
  MatchSample sample;
  sample.found = axes * motion_between(T_map_true, found.T_map_sensor);
  sample.start = axes * motion_between(T_map_true, T_map_start);
  sample.structure.information = axes * structure.information * axes.transpose();
  sample.structure.descent = axes * structure.descent;
  sample.structure.raised = structure.raised;
  sample.likelihood = found.nearest_voxel_likelihood;
  sample.scored_points = found.scored_points;
  return sample;
}

// What a filter learns of x, y and yaw from a match, relative to the start: information, and
// information times the step that scan and map measured.
struct PlanarUpdate {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();
};

// Where a match ended, what is returned of it, and what a filter is given; map axes.
struct LoopMatch {
  bool is_matched = false;
  PlanarPose found = PlanarPose::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  PlanarPose returned = PlanarPose::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  PlanarUpdate update;
};

// A returned pose x of covariance C contains the start x0 of covariance P: without it, it is the
// information C^-1 - P^-1, and pulls by C^-1 (x - x0).
PlanarUpdate without_start(const LoopMatch& match, const PlanarPose& start,
                           const Eigen::Matrix3d& start_covariance) {
  PlanarUpdate update;
  const Eigen::Matrix3d all = match.covariance.inverse();
  update.information = all - start_covariance.inverse();
  update.information = (0.5 * (update.information + update.information.transpose())).eval();
  update.pull = all * difference(match.returned, start);
  return update;
}

LoopMatch match_of_known_start(WorldLocalizer& localizer, const KnownStart& start,
                               const LoopOptions& options, const Pose& T_map_true,
                               MatchSample& sample) {
  LoopMatch result;
  const MatchResult found =
      localizer.match(start.T_map_vehicle, search_of_start_m(start.covariance));
  result.is_matched = found.scored_points > 0;
  if (!result.is_matched) return result;
  const MatchEnd end = localizer.end(found, start, options.scale);
  result.found = planar_pose(found.T_map_sensor);
  result.information = planar_part(end.information);
  result.returned = planar_pose(end.estimate.T_map_vehicle);
  result.covariance = planar_block(end.estimate.covariance);
  result.update =
      without_start(result, planar_pose(start.T_map_vehicle), planar_block(start.covariance));
  sample =
      sample_of(found, start.T_map_vehicle, T_map_true, localizer.structure(found.T_map_sensor));
  sample.point_count = static_cast<std::uint32_t>(localizer.point_count());
  return result;
}

// Of a source that knows nothing of the start.
LoopMatch match_of_rival(WorldLocalizer& localizer, const KnownStart& start,
                         const LoopOptions& options) {
  LoopMatch result;
  const MatchResult found = localizer.match(start.T_map_vehicle);
  result.is_matched = found.scored_points > 0;
  if (!result.is_matched) return result;
  result.covariance = Eigen::Vector3d(0.0225, 0.0225, 0.000625).asDiagonal();
  if (options.source == CovarianceSource::kLaplace) {
    const std::optional<Matrix6d> laplace = covariance_of(found);
    result.covariance = laplace ? planar_block(*laplace) : Eigen::Matrix3d::Identity();
  } else if (options.source == CovarianceSource::kMultiNdt) {
    result.covariance = multi_ndt_covariance(localizer, found);
  }
  result.covariance *= options.rival_factor;
  result.found = result.returned = planar_pose(found.T_map_sensor);
  result.information = result.covariance.inverse();
  result.update.information = result.information;
  result.update.pull =
      result.information * difference(result.found, planar_pose(start.T_map_vehicle));
  return result;
}

}  // namespace

std::string_view source_name(CovarianceSource source) {
  constexpr std::string_view kNames[] = {"fixed", "laplace", "multi-ndt", "structure"};
  return kNames[static_cast<std::size_t>(source)];
}

Matrix6d tracking_start_covariance() {
  Matrix6d covariance = Matrix6d::Zero();
  for (int i = 0; i < 6; ++i) covariance(i, i) = kStartDeviations[i] * kStartDeviations[i];
  return covariance;
}

WorldLocalizer::WorldLocalizer(const IntegrityWorld& world, const Look& look)
    : look_(look),
      own_(make_localizer(world.map, localizer_options(LocalizerKind::kSearching))),
      samples_(localizer_for_samples(own_, world.map)),
      structures_(world.map, own_.levels.back().grid),
      sensor_(world.sensor),
      matcher_({own_, samples_, sensor_, 1.0, false, false}) {}

void WorldLocalizer::take(const Scan& scan) {
  const double begin_s = cpu_s();
  matcher_.take(scan, look_);
  match_s_ += cpu_s() - begin_s;
}

MatchResult WorldLocalizer::match(const Pose& T_map_start, double search_m) {
  const double begin_s = cpu_s();
  const MatchResult found = matcher_.match(T_map_start, search_m);
  match_s_ += cpu_s() - begin_s;
  return found;
}

MatchEnd WorldLocalizer::end(const MatchResult& found, const KnownStart& start,
                             const InformationScale& scale) {
  const double begin_s = cpu_s();
  const MatchEnd end = end_of_match(found, matcher_.scan(), &start, structures_, scale, observer_);
  information_s_ += cpu_s() - begin_s;
  return end;
}

StructureEvidence WorldLocalizer::structure(const Pose& T_map_vehicle) {
  return structure_evidence(structures_, matcher_.scan(), T_map_vehicle, observer_);
}

std::vector<LoopStep> drive_closed_loop(WorldLocalizer& localizer, const TrueDrive& drive,
                                        const LoopOptions& options) {
  Sensors sensors = sensors_of(options.seed);
  PoseFilter filter(planar_pose(drive.T_map_vehicle.front()));
  std::vector<LoopStep> steps;
  for (std::size_t k = 0; k < drive.scans.size(); ++k) {
    const Pose& T_map_true = drive.T_map_vehicle[k];
    const PlanarPose truth = planar_pose(T_map_true);
    const Eigen::Matrix3d axes = axes_at(truth.z());
    if (k > 0) filter.predict(sensors.between(drive.T_map_vehicle[k - 1], T_map_true));
    LoopStep& step = steps.emplace_back();
    step.kind = drive.kinds[k];
    step.is_constrained[0] = drive.constraints[k].kept_ahead <= 0.5;
    step.is_constrained[1] = drive.constraints[k].kept_left <= 0.5;
    localizer.take(drive.scans[k]);
    const KnownStart start = options.has_tracking_starts
                                 ? tracking_start(T_map_true, sensors.random)
                                 : start_of_filter(filter, T_map_true, sensors.random);
    step.start_error = axes * difference(planar_pose(start.T_map_vehicle), truth);
    const LoopMatch match =
        options.source == CovarianceSource::kStructure
            ? match_of_known_start(localizer, start, options, T_map_true, step.sample)
            : match_of_rival(localizer, start, options);
    step.is_matched = match.is_matched;
    if (step.is_matched) {
      step.match_error = axes * difference(match.found, truth);
      step.returned_error = axes * difference(match.returned, truth);
      step.information = axes * match.information * axes.transpose();
      step.match_covariance = axes * match.covariance * axes.transpose();
      if (!options.has_tracking_starts) {
        filter.update_from_here(match.update.pull / options.inflation,
                                match.update.information / options.inflation);
      }
    }
    step.fused_error = axes * difference(filter.pose(), truth);
    step.fused_covariance = axes * filter.covariance() * axes.transpose();
  }
  return steps;
}

}  // namespace sightline

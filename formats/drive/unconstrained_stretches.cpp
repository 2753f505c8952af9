#include "formats/drive/unconstrained_stretches.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/text/numbers.h"

namespace sightline {
namespace {

// Whether a pose is of the stretch of the one before it.
bool continues(const Trajectory& trajectory, std::size_t i) {
  return i > 0 && trajectory.poses[i].unconstrained == trajectory.poses[i - 1].unconstrained &&
         trajectory.poses[i].piece == trajectory.poses[i - 1].piece;
}

// 0 between pieces, whose distance has no meaning.
double step_m(const Trajectory& trajectory, std::size_t i) {
  if (i == 0 || trajectory.poses[i].piece != trajectory.poses[i - 1].piece) return 0.0;
  return (trajectory.poses[i].T_map_vehicle.translation() -
          trajectory.poses[i - 1].T_map_vehicle.translation())
      .norm();
}

bool has_sigma(Substitute substitute) {
  return substitute != Substitute::kNone && substitute != Substitute::kGivenPoses;
}

// By how much the variance of the position grew between two poses, in the directions that are not
// constrained at the later one. A heading moves the vehicle aside.
double grown_m2(const TrajectoryPose& before, const TrajectoryPose& pose) {
  const Eigen::Matrix3d grown = pose.covariance.matrix().topLeftCorner<3, 3>() -
                                before.covariance.matrix().topLeftCorner<3, 3>();
  const auto along = [&](int axis) -> double {
    const Eigen::Vector3d direction = pose.T_map_vehicle.linear().col(axis);
    return std::max(0.0, direction.dot(grown * direction));
  };
  const Unconstrained& directions = pose.unconstrained;
  return (directions.along ? along(0) : 0.0) +
         (directions.across || directions.heading ? along(1) : 0.0);
}

}  // namespace

bool UnconstrainedStretch::is_assumed() const {
  return directions.substitute == Substitute::kNone ||
         directions.substitute == Substitute::kConstantSpeed;
}

std::vector<std::optional<double>> unconstrained_sigmas_m(const Trajectory& trajectory) {
  std::vector<std::optional<double>> sigmas_m(trajectory.poses.size());
  std::size_t before = 0;  // the pose before the stretch
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) {
    const TrajectoryPose& pose = trajectory.poses[i];
    if (!pose.unconstrained.is_any()) continue;
    if (!continues(trajectory, i)) {
      const bool is_within_piece = i > 0 && trajectory.poses[i - 1].piece == pose.piece;
      before = is_within_piece ? i - 1 : i;
    }
    if (!has_sigma(pose.unconstrained.substitute)) continue;
    sigmas_m[i] = std::sqrt(grown_m2(trajectory.poses[before], pose));
  }
  return sigmas_m;
}

std::vector<UnconstrainedStretch> unconstrained_stretches(const Trajectory& trajectory) {
  const std::vector<std::optional<double>> sigmas_m = unconstrained_sigmas_m(trajectory);
  std::vector<UnconstrainedStretch> all;
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) {
    const TrajectoryPose& pose = trajectory.poses[i];
    if (!pose.unconstrained.is_any()) continue;
    const Eigen::Vector3d at_m = pose.T_map_vehicle.translation();
    if (!continues(trajectory, i)) {
      all.push_back({.first_scan = pose.recording_index,
                     .directions = pose.unconstrained,
                     .begin_map_m = at_m});
    }
    UnconstrainedStretch& stretch = all.back();
    stretch.last_scan = pose.recording_index;
    stretch.way_m += step_m(trajectory, i);
    stretch.sigma_m = sigmas_m[i];
    stretch.end_map_m = at_m;
  }
  return all;
}

std::string directions_text(const Unconstrained& directions) {
  std::string text;
  for (const auto& [is_named, name] :
       {std::pair(directions.along, "along the road"), std::pair(directions.across, "across it"),
        std::pair(directions.heading, "in heading")}) {
    if (is_named) text += concat(text.empty() ? "" : ", ", name);
  }
  return text;
}

std::string substitute_text(const UnconstrainedStretch& stretch) {
  const std::string sigma =
      stretch.sigma_m ? concat(", +/- ", fixed(*stretch.sigma_m, 1), " m") : std::string();
  switch (stretch.directions.substitute) {
    case Substitute::kGivenPoses:
      return "the given poses are used";
    case Substitute::kConstantSpeed:
      return "constant speed is assumed" + sigma;
    case Substitute::kWheelSpeed:
      return "wheel speed is used" + sigma;
    case Substitute::kInertial:
      return "accelerations of the inertial unit are used" + sigma;
    case Substitute::kNone:
      break;
  }
  return "the speed before is not known, so the way may be far too short";
}

std::string to_text(const UnconstrainedStretch& stretch) {
  const std::string scans = stretch.first_scan == stretch.last_scan
                                ? concat("scan ", stretch.first_scan)
                                : concat("scans ", stretch.first_scan, " to ", stretch.last_scan);
  return concat(scans, ": ", fixed(stretch.way_m, 1), " m of the way are not constrained ",
                directions_text(stretch.directions), "; ", substitute_text(stretch));
}

}  // namespace sightline

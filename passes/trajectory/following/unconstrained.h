#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/drive/drive.h"
#include "passes/matching/match_score.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/followed_scans.h"

// Where scans do not constrain the motion of an odometry; part of estimate-trajectory.

namespace sightline {

// Steps in a row that scans do not constrain, in one or more of the vehicle's axes.
struct UnconstrainedStretch {
  std::uint32_t first = 0;  // scans, by their place in the drive: those that the steps lead to
  std::uint32_t last = 0;
  double way_m = 0.0;                              // of these steps
  Eigen::Vector3d weak = Eigen::Vector3d::Zero();  // forward, left and turn: mean, 0 to 1
  Forecast forecast = Forecast::kNone;             // what was used instead
  double way_sigma_m = 0.0;                        // standard deviation of the way by the forecast
};

// Ascending. Steps up to 5 m of way apart are one stretch. Shorter ones than 10 m are left out;
// where no forecast was known, as the way may be wrong there, those of fewer than ten scans.
std::vector<UnconstrainedStretch> unconstrained_stretches(const Odometry& odometry);

// "scans 3 to 40: 36.2 m of the way ...": where, in which directions, and what was used.
std::string to_text(const UnconstrainedStretch& stretch, const Drive& drive);

// One warning of all stretches whose motion is not that of given poses; none without any.
void warn_of_unconstrained(const PassContext& ctx, const Drive& drive, const Odometry& odometry);

// What a forecast leaves unknown of each pose, relative to the first of its piece: a speed off
// by its share and a heading that drifts by 0.001 rad/m, both constant over a stretch of weak
// steps. Map axes, order dx dy dz wx wy wz; added to the covariance of the graph. Zero where steps
// are constrained or given. `T_map_lidar` and `T_lidar_vehicle` give the vehicle's axes.
std::vector<Matrix6d> forecast_covariance(const Odometry& odometry,
                                          const std::vector<Pose>& T_map_lidar,
                                          const Pose& T_lidar_vehicle);

}  // namespace sightline

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/drive/trajectory.h"
#include "formats/drive/unconstrained_stretches.h"
#include "passes/matching/match_score.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/followed_scans.h"

// Where scans do not constrain the motion of an odometry; part of estimate-trajectory.

namespace sightline {

// Steps in a row that scans do not constrain in one of the vehicle's axes.
struct WeakSteps {
  int axis = 0;             // forward, left, turn
  std::uint32_t first = 0;  // scans, by their place in the drive: those that the steps lead to
  std::uint32_t last = 0;
  double way_m = 0.0;                   // of these steps
  Forecast forecast = Forecast::kNone;  // what was used instead
  bool has_leap = false;                // of a step (StepConstraint::leap_m)
};

// By axis, then ascending ("Unconstrained poses" in schemas/definitions.md, v2). A step is one
// where the median of what surfaces leave of an error along the axis, over the steps within 8 m of
// way, is above a limit. Such steps up to 5 m of way apart are one stretch. Shorter ones than 10 m
// are left out; where no forecast was known, as the way may be wrong there, those of fewer than ten
// scans. Steps with a leap are named too, however short.
std::vector<WeakSteps> weak_steps(const Odometry& odometry);

// Sets `unconstrained` of the poses that these steps lead to.
void mark_unconstrained(const Odometry& odometry, std::vector<TrajectoryPose>& poses);

// One warning of all stretches that rest on no given poses; none without any.
void warn_of_unconstrained(const PassContext& ctx, const std::string& drive,
                           const Trajectory& trajectory);

// What a forecast leaves unknown of each pose, relative to the first of its piece: a speed off
// by its share and a heading that drifts by 0.001 rad/m, both constant over a stretch of weak
// steps; of an assumed speed 0.7 of the share, and the share once more for each 50 m. Map axes,
// order dx dy dz wx wy wz; added to the covariance of the graph. Zero where steps are constrained
// or given. A step with a leap may be off by as much. `T_map_lidar` and `T_lidar_vehicle` give the
// vehicle's axes.
std::vector<Matrix6d> forecast_covariance(const Odometry& odometry,
                                          const std::vector<Pose>& T_map_lidar,
                                          const Pose& T_lidar_vehicle);

}  // namespace sightline

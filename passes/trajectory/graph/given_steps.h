#pragma once

#include <cstdint>
#include <vector>

#include "formats/drive/drive.h"
#include "passes/matching/match_score.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/local/estimate_options.h"

// How accurate given poses are where scans do not constrain a motion; part of estimate-trajectory.

namespace sightline {

// Standard deviation of the motion by given poses over 1 m of way, of each axis; it grows with the
// root of the way.
struct GivenDrift {
  double sigma_m = 0.0;
  double sigma_rad = 0.0;
};

// By how given and matched motions differ over about 10 m where scans constrain every step: the
// median over the drive. At most, and without such steps, what the options say of given poses.
GivenDrift given_drift(const EstimateTrajectoryOptions& options, const GivenPoses& given,
                       const Odometry& odometry);

// The motions of the sensor at scan k that are those of the given step: a projector, in the
// sensor's axes, translation, then rotation times kTurnArm_m. Zero where scans constrain all.
Matrix6d given_motions(const Drive& drive, const Odometry& odometry, std::size_t k);

// Adds to steps between successive `scans` what given steps leave unknown on the way (`more`).
void add_given_drift(const Drive& drive, const Odometry& odometry, const GivenDrift& drift,
                     const std::vector<std::uint32_t>& scans, std::vector<GraphEdge>& steps);

}  // namespace sightline

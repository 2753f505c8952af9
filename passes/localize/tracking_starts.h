#pragma once

#include <vector>

#include "formats/annotation/direction_errors.h"
#include "formats/base/result.h"
#include "passes/matching/match_score.h"

namespace sightline {

// Where a vehicle that tracks starts the matcher: how far its predicted pose is from the true one,
// standard deviations.
struct TrackingPattern {
  int count = 5;                // 0: none
  double horizontal_m = 0.141;  // of each of the two axes: 0.2 m in the plane, root mean square
  double height_m = 0.05;
  double yaw_deg = 0.5;
};

// "Tracking starts" in schemas/definitions.md, v2: the same at every site. They have exactly these
// standard deviations about a mean of 0, and their axes are uncorrelated.
std::vector<InitialOffset> tracking_offsets(const TrackingPattern& pattern);

// Of such a start, in map axes, for a vehicle with these axes; roll and pitch have the standard
// deviation of the yaw.
Matrix6d tracking_covariance(const TrackingPattern& pattern, const Eigen::Matrix3d& vehicle_axes);

// Where each scan is matched from, relative to its reference.
struct MatchStarts {
  std::vector<InitialOffset> acquiring;  // whose runs make the rows of a measured error
  std::vector<InitialOffset> tracking;   // may be none
  TrackingPattern tracking_pattern;      // their covariance is given to the matcher
};

// Error: bad-value (1 to 4 starts, whose axes would be correlated).
Result<void> validate(const TrackingPattern& pattern);

}  // namespace sightline

#pragma once

// Where the poses of a drive come from; of estimate-trajectory, and of its parts.

namespace sightline {

enum class PoseMode { kAuto, kGiven, kRefine, kEstimate };
enum class BadPoses { kIgnore, kWarn, kRepair, kRefuse };

struct EstimateTrajectoryOptions {
  // auto: given poses where every scan has one, as they are unless refining them makes the map
  // sharper; refined where some have one, estimated where none has. given, refine and estimate say
  // it outright.
  PoseMode mode = PoseMode::kAuto;
  // What happens where given poses move otherwise than the scans show: nothing is compared, a
  // warning says so, poses are refined as well, or they are refused. A jump, by more than three
  // prior sigmas from one scan to the next, is refused unless poses are repaired (then it is left
  // out) or refined by `mode`.
  BadPoses bad_poses = BadPoses::kWarn;
  double prior_sigma_m = 0.5;  // refine: how far a given pose is to be believed
  double prior_sigma_deg = 2.0;
  double prior_correlation_m = 100.0;  // given poses share their error over this much of the way
  double local_map_m = 50.0;           // scans are matched to what was seen on this much of the way
  bool closes_loops = true;            // match again where the route comes back to a place
};

}  // namespace sightline

#pragma once

#include <optional>
#include <vector>

#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"

// What the parts of estimate-trajectory work on.

namespace sightline {

enum class PoseMode { kAuto, kGiven, kRefine, kEstimate };
enum class BadPoses { kIgnore, kWarn, kRepair, kRefuse };

struct EstimateTrajectoryOptions {
  // auto: given poses where every scan has one, as they are unless refining them makes the map
  // sharper; refined where some scans have one, estimated where none has. given, refine and
  // estimate: always this.
  PoseMode mode = PoseMode::kAuto;
  // What happens where given poses move otherwise than the scans show: nothing is compared, a
  // warning is given, poses are refined as well, or they are refused. A jump, by more than three
  // prior sigmas from one scan to the next, is refused unless poses are repaired (then it is left
  // out) or refined by `mode`.
  BadPoses bad_poses = BadPoses::kWarn;
  double prior_sigma_m = 0.5;  // refine: standard deviation of given poses
  double prior_sigma_deg = 2.0;
  double prior_correlation_m = 100.0;  // given poses share their error over this much of the way
  double local_map_m = 50.0;           // scans are matched to those of this much of the way
  bool closes_loops = true;            // match again where the route comes back to a place
};

// A drive whose poses are estimated. Refers to its members.
struct EstimateTask {
  PassContext& ctx;
  const EstimateTrajectoryOptions& options;
  const Drive& drive;
};

// T_map_lidar of each scan of a drive, none where no pose is given.
using GivenPoses = std::vector<std::optional<Pose>>;

}  // namespace sightline

#include "passes/estimate_trajectory.h"

#include <algorithm>

namespace sightline {
namespace {

Result<Trajectory> given_trajectory(const Drive& drive) {
  Trajectory trajectory;
  trajectory.frame = drive.frame;
  for (const ScanInfo& scan : drive.scans) {
    if (!scan.T_world_vehicle) {
      return Error{ErrorCode::kNoPoses, "the recording gives no pose of this scan", scan.source,
                   "scan " + std::to_string(scan.recording_index)};
    }
    trajectory.poses.push_back({scan.recording_index, scan.stamp_ns,
                                rebase(*scan.T_world_vehicle, MapFrame{}, drive.frame)});
  }
  return trajectory;
}

}  // namespace

std::vector<OptionField> option_fields(EstimateTrajectoryOptions& options) {
  return {
      choice("mode", options.mode, "where poses come from",
             {"auto", "given", "refine", "estimate"}),
      number("prior_sigma_m", options.prior_sigma_m,
             "when refining: how far off given positions are, m", 0.001, 1000.0),
      number("prior_sigma_deg", options.prior_sigma_deg,
             "when refining: how far off given headings are, degrees", 0.001, 180.0),
      number("local_map_m", options.local_map_m,
             "scans are matched to what was seen on this much of the way, m", 5.0, 500.0),
      flag("closes_loops", options.closes_loops,
           "match again where the route comes back to a place"),
  };
}

Result<Trajectory> estimate_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                       const Drive& drive) {
  const bool some_given = std::ranges::any_of(
      drive.scans, [](const ScanInfo& scan) { return scan.T_world_vehicle.has_value(); });
  if (options.mode == "given" || (options.mode == "auto" && drive.has_poses())) {
    return given_trajectory(drive);
  }
  ctx.progress(0, drive.scans.size());
  return Error{ErrorCode::kNoPoses, some_given ? "x" : "y", "", ""};
}

}  // namespace sightline

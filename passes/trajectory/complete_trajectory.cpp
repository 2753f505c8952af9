#include "passes/trajectory/complete_trajectory.h"

#include <algorithm>
#include <iterator>

namespace sightline {
namespace {

Error mismatch(const Drive& drive, std::size_t scan, const std::string& message) {
  return {ErrorCode::kMismatchedInputs, message, "", concat("drive ", drive.name, " scan ", scan)};
}

Result<void> check_first_sensor(const Drive& drive, const Trajectory& trajectory) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (drive.scans[i].sensor_index != 0) continue;
    if (next == trajectory.poses.size() ||
        trajectory.poses[next].stamp_ns != drive.scans[i].stamp_ns) {
      return mismatch(drive, i, "the trajectory has no pose of this scan of the first sensor");
    }
    ++next;
  }
  if (next == trajectory.poses.size()) return {};
  return mismatch(drive, drive.scans.size(), "the trajectory has more poses than scans");
}

// Extends the last step of a piece, by at most one step.
Pose carried_on(const std::vector<TrajectoryPose>& known, std::size_t last, std::int64_t stamp_ns) {
  const Pose& T_map_last = known[last].T_map_vehicle;
  if (last == 0 || known[last - 1].piece != known[last].piece) return T_map_last;
  const Pose step = known[last - 1].T_map_vehicle.inverse() * T_map_last;
  const double share = static_cast<double>(stamp_ns - known[last].stamp_ns) /
                       static_cast<double>(known[last].stamp_ns - known[last - 1].stamp_ns);
  return T_map_last * interpolate(Pose::Identity(), step, std::min(1.0, share));
}

}  // namespace

Result<Trajectory> complete_trajectory(PassContext&, const NoOptions&, const Drive& drive,
                                       const Trajectory& first_sensor) {
  SIGHTLINE_TRY(check_first_sensor(drive, first_sensor));
  const std::vector<TrajectoryPose>& known = first_sensor.poses;
  Trajectory complete = first_sensor;
  complete.poses.clear();
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const ScanInfo& scan = drive.scans[i];
    const auto after =
        std::ranges::lower_bound(known, scan.stamp_ns, {}, &TrajectoryPose::stamp_ns);
    if (after == known.end() || (after == known.begin() && after->stamp_ns != scan.stamp_ns)) {
      return mismatch(drive, i, "no scan of the first sensor is on both sides of this one in time");
    }
    TrajectoryPose pose = *after;
    if (after->stamp_ns != scan.stamp_ns) {
      const TrajectoryPose& before = *std::prev(after);
      if (before.piece != after->piece) {
        const auto last = static_cast<std::size_t>(std::prev(after) - known.begin());
        pose = before;
        pose.T_map_vehicle = carried_on(known, last, scan.stamp_ns);
      } else {
        const double fraction = static_cast<double>(scan.stamp_ns - before.stamp_ns) /
                                static_cast<double>(after->stamp_ns - before.stamp_ns);
        pose.T_map_vehicle = interpolate(before.T_map_vehicle, after->T_map_vehicle, fraction);
      }
    }
    pose.recording_index = scan.recording_index;
    pose.stamp_ns = scan.stamp_ns;
    complete.poses.push_back(pose);
  }
  return complete;
}

}  // namespace sightline

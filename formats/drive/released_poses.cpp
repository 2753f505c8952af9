#include "formats/drive/released_poses.h"

#include <map>
#include <optional>

namespace sightline {

Result<ReleasedPoses> release(const Drive& drive, const Trajectory& trajectory) {
  ReleasedPoses released;
  released.trajectory = trajectory;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const std::optional<Digest> scan = drive.store->identity(i);
    if (!scan) {
      return Error{ErrorCode::kInvalidArtifact,
                   "a scan has no name by which it could be known again", "",
                   "scan " + std::to_string(i)};
    }
    released.scans.push_back(*scan);
  }
  return released;
}

std::vector<const TrajectoryPose*> poses_of(const Drive& drive, const ReleasedPoses& released) {
  std::map<Digest, const TrajectoryPose*> pose_of_scan;
  for (std::size_t i = 0; i < released.scans.size(); ++i) {
    pose_of_scan.emplace(released.scans[i], &released.trajectory.poses[i]);
  }
  std::vector<const TrajectoryPose*> poses;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const std::optional<Digest> scan = drive.store->identity(i);
    const auto found = scan ? pose_of_scan.find(*scan) : pose_of_scan.end();
    poses.push_back(found == pose_of_scan.end() ? nullptr : found->second);
  }
  return poses;
}

Result<void> validate(const ReleasedPoses& released) {
  if (released.scans.size() != released.trajectory.poses.size()) {
    return Error{ErrorCode::kInvalidArtifact,
                 "found " + std::to_string(released.scans.size()) + " scans and " +
                     std::to_string(released.trajectory.poses.size()) + " poses"};
  }
  return validate(released.trajectory);
}

Table dump(const ReleasedPoses& released) {
  Table table = dump(released.trajectory);
  table.name = "released-poses";
  table.columns.emplace_back("scan");
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    table.rows[i].emplace_back(to_hex(released.scans[i]));
  }
  return table;
}

}  // namespace sightline

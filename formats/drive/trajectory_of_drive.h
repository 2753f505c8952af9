#pragma once

#include <cstddef>
#include <string>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"

namespace sightline {

// Whether `trajectory` has one pose for each scan of `drive`, in its order.
// Error: mismatched-inputs, naming the first pose that is of another scan.
inline Result<void> check_trajectory_of_drive(const Drive& drive, const Trajectory& trajectory) {
  if (trajectory.poses.size() != drive.scans.size()) {
    return Error{ErrorCode::kMismatchedInputs,
                 "found " + std::to_string(trajectory.poses.size()) + " poses for " +
                     std::to_string(drive.scans.size()) + " scans, expected one each",
                 "", "drive " + drive.name};
  }
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (trajectory.poses[i].recording_index != drive.scans[i].recording_index) {
      return Error{ErrorCode::kMismatchedInputs,
                   "found the pose of scan " + std::to_string(trajectory.poses[i].recording_index) +
                       ", expected that of scan " + std::to_string(drive.scans[i].recording_index),
                   "", "pose " + std::to_string(i)};
    }
  }
  return {};
}

}  // namespace sightline

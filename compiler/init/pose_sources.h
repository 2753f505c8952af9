#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compiler/init/find_scans.h"
#include "formats/foreign/recording/recording.h"

namespace sightline {

// Where poses may come from: a file, or a topic of the bag that holds the scans.
struct PoseSource {
  std::string file;
  std::string topic;
  bool are_transforms = false;          // of a bag: they tell of the sensor itself
  std::optional<Pose> T_vehicle_lidar;  // of a bag, where its transforms tell it
  [[nodiscard]] std::string words() const;
};

// All there are for scans that were listed. A topic of poses comes twice where the bag's
// transforms tell the sensor's mounting: without it and with it.
std::vector<PoseSource> pose_sources(const FoundScans& found, const Recording& listed);

// The options with the poses and mounting of a source; numbers are rounded to micrometres and
// millionths of a degree.
RecordingOptions with_poses(const PoseSource& source, RecordingOptions options);

}  // namespace sightline

#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/recording/recording.h"

namespace sightline {

// A folder of scans, or a file that holds many, and the files near it that may tell of its poses
// and times, the nearest first.
struct FoundScans {
  std::filesystem::path scans;
  std::vector<std::filesystem::path> pose_files;
  std::vector<std::filesystem::path> stamp_files;
};

// What looked like scans and is none; `reason` is a sentence for a person.
struct PassedOver {
  std::filesystem::path path;
  std::string reason;
};

struct ScanSearch {
  std::vector<FoundScans> found;  // in natural order of their paths
  std::vector<PassedOver> passed_over;
};

// Looks for folders with two point cloud files of one kind or more, bags of ROS 1 and ROS 2 and
// pcaps in `folder` and up to four folders deeper; hidden folders are left out. Files of poses have
// 8, 9 or 12 columns of numbers, files of times one; they are beside the scans or above them up to
// `folder`, or in a folder `poses` there, named after them. Errors: file-not-found, cannot-open.
Result<ScanSearch> find_scans(const std::filesystem::path& folder);

// Where poses may come from: a file, or a topic of the bag that holds the scans.
struct FoundPoses {
  std::string file;
  std::string topic;
  bool are_transforms = false;          // of a bag: they tell of the sensor itself
  std::optional<Pose> T_vehicle_lidar;  // of a bag, where its transforms tell it
  [[nodiscard]] std::string words() const;
};

// All there are for scans that were listed. A topic of poses comes twice where the bag's
// transforms tell the sensor's mounting: without it and with it.
std::vector<FoundPoses> pose_sources(const FoundScans& found, const Recording& listed);

// The options with the poses and mounting of a source; numbers are rounded to micrometres and
// millionths of a degree.
RecordingOptions with_poses(const FoundPoses& source, RecordingOptions options);

// How well given poses lay a recording's scans on each other.
struct PoseOverlap {
  std::size_t pairs = 0;  // of scans 2 to 10 m apart that were compared
  double share = 0.0;     // of upright returns of one that fall on returns of the other
  double yaw_deg = 0.0;   // of the sensor beyond its mounting: 0, 90, 180 or -90
  bool is_z_up = true;    // the poses stand upright and move level; a camera's do not
  double length_m = 0.0;  // of the way along the poses
};

// Compares up to six pairs spread over the recording. A return counts as upright more than half a
// metre above the ground `height_m` below the sensor, because ground lies on ground under any yaw;
// it falls on the other scan where that has a return in the same voxel of half a metre. The
// sensor's yaw is 0 unless another one fits far better. Errors: those of read_listed_scan.
Result<PoseOverlap> measure_overlap(const Recording& recording, double height_m);

}  // namespace sightline

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/result.h"

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
// pcaps in `folder` and up to four folders deeper; hidden folders are left out. Files of poses and
// times count where their first line has 8, 9 or 12 columns of numbers, or one; they lie beside the
// scans or above them up to `folder`, or are named after the scans in a folder `poses` there.
// Errors: file-not-found, cannot-open.
Result<ScanSearch> find_scans(const std::filesystem::path& folder);

}  // namespace sightline

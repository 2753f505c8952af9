#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// The file that makes a folder a recording of ros2 bag.
inline constexpr std::string_view kBagMetadata = "metadata.yaml";

// Whether a folder holds the metadata of ros2 bag.
bool is_rosbag2_folder(const std::filesystem::path& folder);

// The files of a recording of ros2 bag, in its order. Errors: cannot-open, cannot-read,
// malformed-header (no files are named), file-not-found (one that is named),
// unsupported-format (files that are packed as a whole, or messages packed by anything but zstd).
Result<std::vector<std::filesystem::path>> files_of_rosbag2(const std::filesystem::path& folder);

}  // namespace sightline

#pragma once

#include <filesystem>
#include <vector>

#include "formats/foreign/recording/recording.h"

namespace sightline {

// Gives every file a time and, where there are any, a pose, by the rules of open_recording; adds to
// recording.scans and recording.warnings. Part of open_recording.
Result<void> describe_scans(const RecordingOptions& options,
                            const std::vector<std::filesystem::path>& files, Recording& recording);

}  // namespace sightline

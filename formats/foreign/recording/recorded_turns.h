#pragma once

#include "formats/base/result.h"
#include "formats/foreign/recording/recording.h"

namespace sightline {

// An imu_topic that says that turn rates are not used.
inline constexpr const char* kNoImu = "none";

// Adds to a recording whose scans lie in a bag the turn rates that the bag holds (read_bag_turns),
// about the axes of the vehicle's frame, from a second before the first scan to a second behind the
// last one; and to its warnings what is to be known of them. Nothing where imu_topic is kNoImu.
// Part of open_recording. Errors: those of read_bag_turns; bad-value (a topic is named, and the
// scans are in no bag).
Result<void> take_turn_rates(const RecordingOptions& options, Recording& recording);

}  // namespace sightline

#pragma once

#include "formats/base/result.h"
#include "formats/foreign/recording/recording.h"

// What a vehicle measures of its own motion, in the bag that holds the scans; part of
// open_recording. Samples from a second before the first scan to a second behind the last are kept;
// a warning where there are samples, none of them in this time.

namespace sightline {

// Turn rates and specific forces of the bag's inertial unit, about the vehicle's axes; none for
// imu_topic "none". Errors: those of read_bag_turns; bad-value (a topic is named, and the scans are
// in no bag).
Result<void> take_inertial_unit(const RecordingOptions& options, Recording& recording);

// Speeds of the wheels; none for wheel_speed "none". Errors: those of read_bag_speeds; bad-value (a
// topic is named, and the scans are in no bag).
Result<void> take_wheel_speeds(const RecordingOptions& options, Recording& recording);

}  // namespace sightline

#pragma once

#include "formats/base/result.h"
#include "formats/foreign/recording/recording.h"

namespace sightline {

// Refuses scans whose points are in the world's frame already, as SLAM programs publish registered
// clouds: the middle of their points moves as the sensor does by its poses (where there are none,
// by the VIEWPOINT of PCD files), while points in the sensor's frame stay around it. Compares up to
// eight scans spread over the recording that are 30 m apart or farther; without such scans nothing
// is refused. Errors: unsupported-format, and those of read_listed_scan.
Result<void> check_frame(const Recording& recording);

}  // namespace sightline

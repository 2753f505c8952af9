#pragma once

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/foreign/recording/recording.h"

namespace sightline {

// Refuses scans whose ground is above the sensor: it is mounted upside down, or z is negated. In
// three quarters of up to five scans, by given poses or else by the mounting, at least 15 % of the
// returns 3 to 20 m away are at one height above the sensor, 3 times as many as at any height below
// it, and hardly any are higher. `drive`: of the scans of `recording`. Errors: unsupported-format,
// and those of read_listed_scan.
Result<void> check_upright(const Recording& recording, const Drive& drive);

}  // namespace sightline

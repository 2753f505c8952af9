#pragma once

#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"

// Scans whose files give no times, yet hold their points in an order that tells something of them.

namespace sightline {

// The drive with a time for each point, half of a scan before its stamp and half behind it: where
// the pose of a scan taken as rigid comes to lie. One drive where the order of the points is that
// of time (see sweep_times), one for each way in which the sensor may have turned where rings
// follow each other (see turns_of_rings). A scan lasts as long as the usual step from one to the
// next, but 0.1 s at most, and a tenth of that where the vehicle would come more than 4 m
// meanwhile: then the recording lacks most scans and its stamps do not say so. One pose for each
// scan. None where a scan has times of its own, where there are several sensors, and where the
// first and the middle scan are in another order.
Result<std::vector<Drive>> swept_drives(const Drive& drive, const Trajectory& trajectory);

}  // namespace sightline

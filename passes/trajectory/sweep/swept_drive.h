#pragma once

#include "formats/base/result.h"
#include "formats/drive/drive.h"

// Scans whose files give no times, yet hold their points in the order in which they were measured.

namespace sightline {

// The drive with a time for each point that its place in the scan's order tells (see sweep_times),
// half of a scan before its stamp and half behind it: where the pose of a scan taken as rigid comes
// to lie. A scan lasts as long as the usual step from one to the next, but 0.1 s at most. The same
// drive where a scan has times of its own, where there are several sensors, and where the first and
// the middle scan are in another order.
Result<Drive> with_sweep_times(const Drive& drive);

}  // namespace sightline

#pragma once

#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"

namespace sightline {

// Whether any scan has times of its points.
bool has_point_times(const Drive& drive);

// The drive with a time for each point, half of a scan before its stamp and half behind it, since a
// scan taken as rigid is matched where its middle was. One drive where the order of the points is
// that of time (sweep_times), one for each possible turn of the sensor where rings follow each
// other (turns_of_rings). A scan lasts as long as the median step to the next, but 0.1 s at most,
// and a tenth of that where the vehicle would move more than 4 m meanwhile: then the recording
// lacks most scans and its stamps are wrong. One pose for each scan. None where a scan has times of
// its own, where there are several sensors, and where the first and the middle scan are in another
// order.
Result<std::vector<Drive>> swept_drives(const Drive& drive, const Trajectory& trajectory);

}  // namespace sightline

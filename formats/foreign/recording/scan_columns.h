#pragma once

#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/recording/recording.h"

namespace sightline {

// Settles what the floats of scans without a header are, by the evidence of each file in the order
// of the scans: where the recording has columns, whether a file refutes them; else the count of
// floats a point that fits all files. Warns where that is not KITTI's four. Errors:
// unsupported-format (none fits, or several, or the given ones cannot be), truncated-scan,
// mixed-formats (each file speaks for a count, and not for the same).
Result<void> settle_columns(const std::vector<FloatEvidence>& evidence, Recording& recording);

}  // namespace sightline

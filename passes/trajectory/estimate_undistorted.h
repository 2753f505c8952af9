#pragma once

#include <functional>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/graph/check_poses.h"

namespace sightline {

// Estimates the poses of a drive whose scans are rigid.
using EstimatePoses = std::function<Result<Estimate>(PassContext& ctx, const Drive& drive)>;

// Poses by undistorted scans: estimated, undistorted with those poses, and estimated again, twice.
// Returned where undistorted scans fit each other more sharply by them than the scans as they are
// by `rigid`, the first estimate; else `rigid` is. Tried on a stretch of each of several drives
// first (middle_of), with all times that the order of points may mean (swept_drives), or without
// and with the drive's turn rates. Without warnings: those of the first estimate are enough.
// Errors: those of `estimate`, except of trials that fail, and of reading a scan.
Result<Estimate> estimate_undistorted(PassContext& ctx, const Drive& drive, const Estimate& rigid,
                                      const EstimatePoses& estimate);

}  // namespace sightline

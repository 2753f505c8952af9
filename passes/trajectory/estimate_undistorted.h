#pragma once

#include <functional>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// Estimates the poses of a drive's scans taken as rigid.
using EstimatePoses = std::function<Result<Trajectory>(PassContext& ctx, const Drive& drive)>;

// Poses for scans that are undistorted: estimated, undistorted with those poses, and estimated
// again, twice. They are taken where they lay undistorted scans on each other more sharply than
// `rigid`, the first estimate, lays the scans as they are; else `rigid` is the answer. Tried on a
// stretch of the drive first (see middle_of); where the order of the points leaves several times
// open (see swept_drives), with each of them; where the drive has point times and turn rates,
// without these and with them. Each of several drives is tried for itself; scans of those that get
// no sharper stay as they are. Scans without times of any kind: `rigid`. Further estimates warn of
// nothing: the first one did.
Result<Trajectory> estimate_undistorted(PassContext& ctx, const Drive& drive,
                                        const Trajectory& rigid, const EstimatePoses& estimate);

}  // namespace sightline

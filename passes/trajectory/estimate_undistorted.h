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
// `rigid`, the first estimate, lays the scans as they are; else `rigid` is the answer. Tried on the
// middle of the drive first; where the order of the points leaves several times open (see
// swept_drives), with each of them; where the drive has point times and turn rates, without these
// and with them. Scans without times of any kind: `rigid`. Further estimates warn of nothing: the
// first one did.
Result<Trajectory> estimate_undistorted(PassContext& ctx, const Drive& drive,
                                        const Trajectory& rigid, const EstimatePoses& estimate);

}  // namespace sightline

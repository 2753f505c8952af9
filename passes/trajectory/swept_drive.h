#pragma once

#include <functional>

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass_context.h"

// Scans whose files give no times, yet hold their points in the order in which they were measured.

namespace sightline {

// The drive with a time for each point that its place in the scan's order tells (see sweep_times),
// half of a scan before its stamp and half behind it: where the pose of a scan taken as rigid comes
// to lie. A scan lasts as long as the usual step from one to the next, but 0.1 s at most. The same
// drive where a scan has times of its own, where there are several sensors, and where the first and
// the middle scan are in another order.
Result<Drive> with_sweep_times(const Drive& drive);

// Estimates the poses of a drive's scans taken as rigid.
using EstimatePoses = std::function<Result<Trajectory>(PassContext& ctx, const Drive& drive)>;

// Poses for scans that are undistorted: estimated, undistorted with those poses, and estimated
// again, twice. They are taken where they lay undistorted scans on each other more sharply than
// `rigid`, the first estimate, lays the scans as they are; else `rigid` is the answer. Tried on the
// middle of the drive first. Scans without times of any kind: `rigid`. Further estimates warn of
// nothing: the first one did.
Result<Trajectory> estimate_undistorted(PassContext& ctx, const Drive& drive,
                                        const Trajectory& rigid, const EstimatePoses& estimate);

// Whether scans undistorted with the trajectory lie on each other more sharply than as they are.
Result<bool> is_sharper_undistorted(PassContext& ctx, const Drive& drive, const Drive& undistorted,
                                    const Trajectory& trajectory);

}  // namespace sightline

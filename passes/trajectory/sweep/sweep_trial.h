#pragma once

#include <optional>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// At most 60 scans of a drive, and their poses: those nearest to its middle on which the vehicle
// moves 5 m, since it may stand at a light there; those of the middle where it never does. Scans
// count from 0 anew.
Drive middle_of(const Drive& drive, const Trajectory& trajectory);
Trajectory middle_of(const Trajectory& trajectory);

// Mean map entropy of the scans of the middle ("Sharpness" in schemas/definitions.md), nat.
Result<double> middle_entropy_nat(PassContext& ctx, const Drive& drive,
                                  const Trajectory& trajectory);

// Whether entropies differ by more than noise does.
bool is_sharper(double after_nat, double before_nat);

// A drive without times, with times by the order of its points: where several are possible
// (swept_drives), those by which the scans, undistorted with the trajectory, are sharpest. None
// where the order gives no times.
Result<std::optional<Drive>> sharpest_sweep(PassContext& ctx, const Drive& drive,
                                            const Trajectory& trajectory);

// Whether the scans undistorted with the trajectory are sharper than the scans as they are.
Result<bool> is_sharper_undistorted(PassContext& ctx, const Drive& drive, const Drive& undistorted,
                                    const Trajectory& trajectory);

}  // namespace sightline

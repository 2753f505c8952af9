#pragma once

#include <optional>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass_context.h"

// Whether undistorting scans pays, tried on the middle of a drive of one part.

namespace sightline {

// At most 60 scans of a drive, and their poses: those nearest to its middle on which the vehicle
// comes 5 m on, since it may have stood at a light there, and those of the middle where it nowhere
// does. Scans count from 0 anew.
Drive middle_of(const Drive& drive, const Trajectory& trajectory);
Trajectory middle_of(const Trajectory& trajectory);

// How sharply the scans of the middle lie on each other ("Sharpness" in definitions.md), nat.
Result<double> middle_entropy_nat(PassContext& ctx, const Drive& drive,
                                  const Trajectory& trajectory);

// Whether entropies differ by more than they do where nothing is gained.
bool is_sharper(double after_nat, double before_nat);

// A drive without times with those that its scans tell: of several ways in which they may have been
// measured (see swept_drives) the one that, undistorted with the trajectory, lays them on each
// other most sharply. None where they tell nothing.
Result<std::optional<Drive>> sharpest_sweep(PassContext& ctx, const Drive& drive,
                                            const Trajectory& trajectory);

// Whether scans undistorted with the trajectory lie on each other more sharply than as they are.
Result<bool> is_sharper_undistorted(PassContext& ctx, const Drive& drive, const Drive& undistorted,
                                    const Trajectory& trajectory);

}  // namespace sightline

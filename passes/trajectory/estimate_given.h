#pragma once

#include <functional>

#include "formats/base/result.h"
#include "formats/drive/trajectory.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/graph/check_poses.h"
#include "passes/trajectory/local/estimate_options.h"

// Poses that are given with a drive: kept, refined or refused; part of estimate-trajectory.

namespace sightline {

// Estimates poses by odometry and by those given poses that are used.
using SolvePoses =
    std::function<Result<Estimate>(const GivenPoses& given, const Odometry& odometry)>;

// The given poses where the scans do not contradict them. Jumps are refused, or left out and the
// other poses refined (repair); other disagreements are treated as `bad_poses` demands. In mode
// auto all are refined where that makes scans fit each other more sharply, with a warning, unless
// the scans are distorted by more than 0.1 degrees (`uneven_rad`, see StraightDrive). Errors:
// no-poses (place: the first scan without one), mismatched-inputs (refused), those of run_odometry
// and of `solve`.
Result<Estimate> check_given(const EstimateTask& task, double uneven_rad, const SolvePoses& solve);

// The given poses, of some scans or of all, refined. Jumps are refused or, in mode refine or to
// repair, left out. Errors: mismatched-inputs (refused), those of run_odometry and of `solve`.
Result<Estimate> refine_given(const EstimateTask& task, const SolvePoses& solve);

// The drive by whose scans given poses are checked.
struct StraightDrive {
  Drive drive;
  // How far the vehicle's turning within a sweep may be from an even one, by the given poses of
  // three scans in a row: root mean square over the part where it is largest. 0 where scans have no
  // point times or turn rates show the turning.
  double uneven_rad = 0.0;
};
// The drive as it is or, where that is sharper, undistorted by the times of its points, its turn
// rates and the given poses. Without that, right poses would seem to contradict scans that are
// distorted. Errors: those of reading a scan.
Result<StraightDrive> undistorted_by_given(PassContext& ctx, const Drive& drive);

}  // namespace sightline

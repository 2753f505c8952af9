#pragma once

#include <cstddef>

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"

namespace sightline {

// The drive with every point that has a time moved to where it was at the stamp
// (undistort_scans.h), with a TurnCurve where the drive's turn rates cover the time. Scans are
// changed when they are read, and lose their times, as the drive its turn rates. One pose for each
// scan.
Drive undistorted(const Drive& drive, const Trajectory& trajectory);

// The poses of the scans of a drive's first sensor: those of others were interpolated between them
// (complete_trajectory) and contain no turning of their own.
Trajectory poses_of_first_sensor(const Drive& drive, const Trajectory& trajectory);

// How many scans with times have no other pose nearby: their points are not moved.
std::size_t scans_without_motion(const Drive& drive, const Trajectory& trajectory);

// The drive with every point that has a time turned by the vehicle's turning between that time and
// the scan's stamp, by the drive's turn rates alone (TurnCurve::by_rates), about the vehicle's
// origin: only the forward motion remains. Scans that rates do not cover stay. For a first
// odometry; scans are changed when they are read, and keep their times.
Drive without_turning(const Drive& drive);

}  // namespace sightline

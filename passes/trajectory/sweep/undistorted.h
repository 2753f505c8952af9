#pragma once

#include <cstddef>

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"

// Taking the motion of a vehicle out of its scans; what undistort-scans does, without a question.

namespace sightline {

// The drive with every point that has a time moved as undistort_scans.h says, between two poses
// with the drive's turn rates where they cover the time (see TurnCurve). Scans are changed when
// they are read, and carry no times any more, nor the drive turn rates. One pose for each scan.
Drive undistorted(const Drive& drive, const Trajectory& trajectory);

// The poses of the scans of a drive's first sensor: those of others were interpolated evenly
// between them (complete_trajectory), and tell nothing of how the vehicle turned.
Trajectory poses_of_first_sensor(const Drive& drive, const Trajectory& trajectory);

// How many scans with times have no pose beside them that tells how the vehicle moved: their points
// stay.
std::size_t scans_without_motion(const Drive& drive, const Trajectory& trajectory);

}  // namespace sightline

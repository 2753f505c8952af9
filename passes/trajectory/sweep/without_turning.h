#pragma once

#include "formats/drive/drive.h"

namespace sightline {

// The drive with every point that has a time turned as the vehicle turned between that time and the
// scan's stamp, by the drive's turn rates alone (TurnCurve::by_rates), about the vehicle's origin:
// what is left in a scan is that the vehicle moved along. Scans that rates do not cover stay. For
// odometry that is to begin; scans are changed when they are read, and keep their times.
Drive without_turning(const Drive& drive);

}  // namespace sightline

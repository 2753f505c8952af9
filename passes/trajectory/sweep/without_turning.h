#pragma once

#include "formats/drive/drive.h"

namespace sightline {

// The drive with every point that has a time turned by the vehicle's turning between that time and
// the scan's stamp, by the drive's turn rates alone (TurnCurve::by_rates), about the vehicle's
// origin: only the forward motion remains. Scans that rates do not cover stay. For a first
// odometry; scans are changed when they are read, and keep their times.
Drive without_turning(const Drive& drive);

}  // namespace sightline

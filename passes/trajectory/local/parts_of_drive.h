#pragma once

#include <vector>

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"

// The drives that one drive was joined from (join-drives), each by itself: their scans may have
// been measured by sensors that turn otherwise, by clocks of other vehicles, and be undistorted
// already or not.

namespace sightline {

// The parts of a drive in their order, each a drive of one part under its own name, with the turn
// rates that are nearer to it in time than to another; the drive itself where it has one part.
std::vector<Drive> parts_of(const Drive& drive);

// The poses of each of `parts`, which are parts_of(drive); pieces keep their numbers.
std::vector<Trajectory> trajectories_of_parts(const std::vector<Drive>& parts,
                                              const Trajectory& trajectory);

// The drive with the scans, times and turn rates that its parts have now: parts_of(drive), of which
// some were changed as they are read. Scans keep their number and order.
Drive joined_again(const Drive& drive, const std::vector<Drive>& parts);

}  // namespace sightline

#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"

// The drives that were joined into one (join-drives), each by itself: their scans may come from
// other sensors, with other clocks, and be undistorted already or not.

namespace sightline {

// The parts of a drive in their order, each a drive of one part under its own name, with the turn
// rates that are nearer to it in time than to another; the drive itself where it has one part.
std::vector<Drive> parts_of(const Drive& drive);

// The poses of each of `parts`, which are parts_of(drive); pieces keep their numbers.
std::vector<Trajectory> trajectories_of_parts(const std::vector<Drive>& parts,
                                              const Trajectory& trajectory);

// The drive with the scans, times and turn rates of its parts, which are parts_of(drive) with some
// scans changed when they are read. Scans keep their number and order.
Drive joined_again(const Drive& drive, const std::vector<Drive>& parts);

// The drive with each part as `change` returns it; where it returns none for every part, the drive
// as it is. Error: that of `change`.
using ChangePart =
    std::function<Result<std::optional<Drive>>(const Drive& part, const Trajectory& poses)>;
Result<Drive> change_parts(const Drive& drive, const Trajectory& trajectory,
                           const ChangePart& change);

// `count` scans of a drive from the `first` on as a drive of their own: scans count from 0 anew.
Drive stretch_of(const Drive& drive, std::size_t first, std::size_t count);
// Their poses. Pieces count from that of the first pose.
Trajectory stretch_of(const Trajectory& trajectory, std::size_t first, std::size_t count);

// T_map_lidar of each scan, by the place of the drive's first sensor in the vehicle.
std::vector<Pose> sensor_poses(const Drive& drive, const Trajectory& trajectory);

}  // namespace sightline

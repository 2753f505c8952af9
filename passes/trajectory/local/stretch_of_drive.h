#pragma once

#include <cstddef>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"

namespace sightline {

// `count` scans of a drive from the `first` on as a drive of their own: scans count from 0 anew.
Drive stretch_of(const Drive& drive, std::size_t first, std::size_t count);
// Their poses. Pieces count from that of the first pose.
Trajectory stretch_of(const Trajectory& trajectory, std::size_t first, std::size_t count);

// T_map_lidar of each scan, by the place of the drive's first sensor in the vehicle.
std::vector<Pose> sensor_poses(const Drive& drive, const Trajectory& trajectory);

}  // namespace sightline

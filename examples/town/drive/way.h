#pragma once

#include <vector>

#include "examples/town/drive/drive_options.h"
#include "examples/town/whole/town.h"
#include "formats/geometry.h"

// Where a car is that drives through a town; part of drive.

namespace sightline::town {

// Arc length of the driven line after so many scans, which may be parts of one.
double driven_line_m(const DriveOptions& options, double scans);

// T_town_vehicle there, true: on the ground, and how far it looks to the left of the way.
Pose pose_on_way(const Town& town, const DriveOptions& options, double scans, double look_rad);

// At every scan.
std::vector<Pose> follow_line(const Town& town, const DriveOptions& options);

}  // namespace sightline::town

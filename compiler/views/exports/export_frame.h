#pragma once

#include <Eigen/Core>

#include "formats/annotation/sites.h"
#include "formats/geodesy.h"
#include "formats/geometry.h"
#include "formats/text/table.h"

// Where exports lie: a vehicle that localizes in an exported map asks the compiled one at the same
// coordinates.

namespace sightline {

// What is taken off world coordinates where clouds of 32-bit floats are written: 0, or whole 100 km
// (export_origin_world_m in formats/reader/map_layout.h; MapInfo has it for the vehicle).
Eigen::Vector3d export_origin_m(const MapFrame& frame);

// What is added to map coordinates there.
Eigen::Vector3d export_shift_m(const MapFrame& frame);

// Moves the positions of a dump from map to world coordinates: columns p_, mean_ and of poses.
void to_world(const MapFrame& frame, Table& table);

// Adds longitude_deg, latitude_deg and height_m to a dump of sites, of a world that is not local.
// Error: bad-argument (a site is no point of the world).
Result<void> add_degrees(const Sites& sites, const World& world, Table& table);

}  // namespace sightline

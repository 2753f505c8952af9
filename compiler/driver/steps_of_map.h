#pragma once

#include "compiler/driver/plans.h"

// The steps that make a map: of mapping drives, or of one that somebody finished; of pipelines.

namespace sightline {

// What makes the map: the scans of all sensors on the vehicle, and a pose for each.
struct MappingDrive {
  Wire<Drive> drive;
  Wire<Trajectory> trajectory;
};

// Joins the scans of the vehicle's other sensors to those of the first, one sensor after the other.
MappingDrive with_other_sensors(const CompileConfig& config, const MappingDrive& first,
                                CompilePlan& compile);

// Joins the other drives that make the map to the first.
Wire<Drive> with_later_drives(const CompileConfig& config, Wire<Drive> drive, CompilePlan& compile);

// Where the mapping drives were; beside an earlier map, where that left them.
void add_trajectory(const CompileConfig& config, CompilePlan& compile);

// The map: NDs, surface, sites and the paper's factors.
Wire<FactorTable> add_map(const CompileConfig& config, const MappingDrive& mapping,
                          Wire<SensorProfile> localizing_sensor, CompilePlan& compile);

// NDs and surface of a finished map, the places along its route, and what simulated scans tell of
// them.
void add_finished_map(const CompileConfig& config, CompilePlan& compile);

}  // namespace sightline

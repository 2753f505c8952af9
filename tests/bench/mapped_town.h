#pragma once

#include <vector>

#include "examples/town/town.h"
#include "formats/drive/drive.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {

// A generated town as a vehicle meets it: the map of drive 0, without what moved, and the scans of
// drive 2 with their true poses.
struct MappedTown {
  NdtMap map;
  SensorProfile sensor;
  std::vector<Scan> scans;
  std::vector<Pose> T_map_vehicle;  // true
};

MappedTown make_mapped_town(const town::TownOptions& options, int beams, int threads);

}  // namespace sightline

#pragma once

#include <cstdint>
#include <vector>

#include "examples/town/whole/town.h"
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

struct HarderDrive {
  // Of each 60 m of the route so much has other houses since, in their middle: other heights and
  // fronts, and half of them set back by up to 2 m. Each place meets its own 60 m rebuilt, and
  // everything else as it was.
  double rebuilt_share = 0.0;
  double traffic = 1.0;        // times the usual
  double missing_share = 0.0;  // of returns, by chance
};

struct MappedTownOptions {
  town::TownOptions town;
  int beams = 16;
  HarderDrive harder = {};
  int threads = 0;
};
MappedTown make_mapped_town(const MappedTownOptions& options);

// Another drive through that town by its number, 1 and up, as hard.
struct TownDrive {
  std::vector<Scan> scans;
  std::vector<Pose> T_map_vehicle;  // true
};
TownDrive drive_through_town(const MappedTownOptions& options, std::uint64_t number,
                             const SensorProfile& sensor);

}  // namespace sightline

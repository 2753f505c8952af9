#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "examples/town/drive/constraint.h"
#include "examples/town/whole/town.h"
#include "formats/drive/drive.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {

// A drive through a generated world with all that is true of it.
struct TrueDrive {
  std::vector<Scan> scans;
  std::vector<Pose> T_map_vehicle;
  std::vector<std::string> kinds;             // of place, by scan
  std::vector<town::Constraint> constraints;  // by scan: of the nearest scan that was examined
};

// The map of drive 0 of a world, and other drives through it.
struct IntegrityWorld {
  std::string kind;
  std::uint64_t seed = 0;
  NdtMap map;
  SensorProfile sensor;
  std::vector<TrueDrive> drives;
};

struct IntegrityWorldOptions {
  std::string world = "town";
  std::uint64_t seed = 1;
  double length_m = 300.0;
  int beams = 16;
  std::vector<std::uint64_t> drives = {1};
  double constraints_every_m = 10.0;
  int threads = 0;
};
Result<IntegrityWorld> make_integrity_world(const IntegrityWorldOptions& options);

}  // namespace sightline

#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "passes/matching/covariance/known_start.h"
#include "passes/matching/look_cutter.h"
#include "passes/matching/look_plan.h"
#include "passes/vehicle/map_windows.h"
#include "passes/vehicle/sightline_localizer.h"
#include "passes/vehicle/vehicle_map.h"

// What the C interface's handle holds.

namespace sightline {

// All that a match needs memory for. A call takes a free one and gives it back, so that several
// threads can match, and a vehicle that matches scan after scan allocates next to nothing.
struct Workspace {
  Scan scan;
  LookMatcher matcher;
  LookMemory planned;
  StructureObserver observer;
};

}  // namespace sightline

struct sightline_localizer {
  explicit sightline_localizer(sightline::VehicleMap opened);

  [[nodiscard]] std::unique_ptr<sightline::Workspace> take_workspace(
      const sightline::MapWindow& window) const;
  void give_back(std::unique_ptr<sightline::Workspace> workspace) const;

  sightline::VehicleMap map;      // its NDs are below
  std::vector<sightline_nd> nds;  // of a map that is held whole
  std::unique_ptr<sightline::MapWindows> windows;
  std::string kernel;
  mutable std::mutex mutex;
  mutable std::vector<std::unique_ptr<sightline::Workspace>> free;
};

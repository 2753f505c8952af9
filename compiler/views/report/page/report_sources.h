#pragma once

#include <string>

#include "compiler/views/report/page/gate_result.h"
#include "formats/annotation/drive_tracks.h"
#include "formats/drive/trajectory.h"
#include "formats/evaluation/evaluation.h"
#include "formats/map/compiled_map.h"
#include "formats/map/diff/map_diff.h"
#include "formats/map/map_reader.h"
#include "formats/surroundings/site_views.h"
#include "formats/surroundings/surface.h"
#include "formats/surroundings/surface_points.h"
#include "passes/weakness/find_weakness.h"

namespace sightline {

// What a report is made of. A null pointer: not known here; the page then says so and leaves out
// what it would have shown. All artifacts are of the map's sites, ranges and limits.
struct ReportSources {
  const CompiledMap* map = nullptr;  // always there
  MapSummary summary;
  std::string map_file;                     // as the user named it
  std::string provenance;                   // the JSON text beside the map; empty: none
  const MeasuredError* measured = nullptr;  // of the drive that judges the map
  const Evaluation* evaluation = nullptr;   // of the same drive
  const DriveTracks* tracks = nullptr;      // of the same drive
  const Trajectory* trajectory = nullptr;   // of the mapping drive
  const SurfacePoints* points = nullptr;    // of which what moved is shown
  const Surface* surface = nullptr;
  const DepthImages* depth = nullptr;
  const MapDiff* diff = nullptr;  // from an older map to this one
  std::string old_map_file;       // of the older map, as the user named it; empty: no diff
  const GateResult* gate = nullptr;
  const Weakness* weakness = nullptr;  // of the tightest limit
};

}  // namespace sightline

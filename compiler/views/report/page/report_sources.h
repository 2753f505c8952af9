#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compiler/views/verdict/evaluation_figures.h"
#include "formats/annotation/drive_tracks.h"
#include "formats/base/result.h"
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

// What `sightline gate --json` wrote, as far as the page shows it.
struct GateResult {
  struct Violation {
    std::string rule;
    std::string severity;  // "note", "warning", "error"
    std::string message;
    std::optional<std::uint32_t> first_site;  // where it has a place in this map
  };
  std::string root_digest;  // of the map that was judged, hexadecimal
  bool passed = false;
  std::uint32_t errors = 0;
  std::uint32_t warnings = 0;
  std::uint32_t notes = 0;
  std::uint32_t excepted = 0;
  std::vector<Violation> violations;
};

// Errors: malformed-text where it is not what `gate --json` writes; those of reading a file.
Result<GateResult> read_gate_result(const std::filesystem::path& file);

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
  const EvaluationFigures* figures = nullptr;  // of the evaluation that the verdict is by
  const Weakness* weakness = nullptr;          // of the tightest limit
};

}  // namespace sightline

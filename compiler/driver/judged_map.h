#pragma once

#include "compiler/driver/compile_config.h"
#include "compiler/pipeline/runner.h"
#include "formats/map/compiled_map.h"

// A finished map as what a drive is judged against (evaluate_pipeline).

namespace sightline {

// The drive is measured at the map's own ranges and, where it is the recording that also made the
// map, on the scans that the map did not use.
void aim_at_map(const CompiledMap& map, CompileConfig& config);

// Provides "ndt-map", "sites", "predicted-error", "range-table" and "factor-table".
void provide_map(const CompiledMap& map, ArtifactSet& artifacts);

}  // namespace sightline

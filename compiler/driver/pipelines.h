#pragma once

#include <vector>

#include "compiler/driver/compile_config.h"
#include "compiler/pipeline/runner.h"

namespace sightline {

// From drives to a finished map. Artifacts taken from outside: "mapping/recording",
// "localization/sensor", and "localization/recording" where a second drive is named. The last two
// made are "evaluation" and "compiled-map".
std::vector<PassStep> compile_pipeline(const CompileConfig& config);

// Judges a finished map by an independent drive. Artifacts taken from outside:
// "evaluation/recording", and from the map "ndt-map", "sites", "predicted-error", "range-table".
// The last one made is "evaluation".
std::vector<PassStep> evaluate_pipeline(const CompileConfig& config);

// Opens the recordings that a compile takes and provides them and their sensors. Errors: those of
// open_recording.
Result<void> provide_drives(const CompileConfig& config, ArtifactSet& artifacts);

// The same for the recording that judges a map.
Result<void> provide_evaluation(const CompileConfig& config, ArtifactSet& artifacts);

}  // namespace sightline

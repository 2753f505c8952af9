#pragma once

#include <filesystem>

#include "compiler/driver/plans.h"
#include "compiler/pipeline/plan.h"

// What plans take from outside.

namespace sightline {

// Opens the recordings of a plan, or its finished map and route, and provides them, their sensors
// and cards, and reads the files of import-errors. Digests of scan files are kept in the cache,
// where there is one (not empty). Errors: those of open_recording, open_point_map, read_route and
// read_outside_errors;
// bad-value where two drives have the same scans.
Result<void> provide_drives(const CompilePlan& compile,
                            const std::filesystem::path& cache_directory, ArtifactSet& artifacts);
Result<void> provide_drive(const EvaluatePlan& evaluate,
                           const std::filesystem::path& cache_directory, ArtifactSet& artifacts);

// Provides what a map holds.
void provide_map(const CompiledMap& map, const EvaluatePlan& evaluate, ArtifactSet& artifacts);

// Cards of the recordings of a plan that were provided, in the order of the configuration's
// sections.
RecordingCards recording_cards(const CompilePlan& compile, const ArtifactSet& artifacts);

// The error model of a finished map (.slmap) or of a model file. Errors: those of read_map,
// model_of and from_bytes.
Result<ByFamily<ErrorModel>> read_model(const std::filesystem::path& file);
// Provides it to a plan that is given one (file empty: it is not). Errors: those of read_model.
Result<void> provide_model(const CompilePlan& compile, const std::filesystem::path& file,
                           ArtifactSet& artifacts);

}  // namespace sightline

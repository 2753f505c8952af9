#pragma once

#include <string>

#include "compiler/config/compile_config.h"
#include "compiler/driver/plans.h"
#include "compiler/views/verdict/drive_origin.h"

namespace sightline {

// Whose evidence an evaluation is ("Identity of recordings" in schemas/definitions.md).
struct KnownDrive {
  DriveOrigin origin = DriveOrigin::kOther;
  std::string why;  // of kKnown and kUnknown: part of a sentence
};

// Compares the evaluation drive, which was identified, with the recordings that the map, its errors
// and its model were made from. Where the map lists none, or its model no scans of them, by digests
// and by the configuration. Errors: those of model_of().
Result<KnownDrive> known_drive(const CompiledMap& map, const CompileConfig& config,
                               const EvaluatePlan& evaluate, const ArtifactSet& artifacts);

}  // namespace sightline

#pragma once

#include <filesystem>
#include <vector>

#include "compiler/driver/compile_config.h"
#include "compiler/pipeline/runner.h"

namespace sightline {

// Where the error model comes from: learnt from this compile's own localization drive, or made
// elsewhere and provided as "error-model".
enum class ModelSource { kTrained, kGiven };

// From drives to a finished map. Artifacts taken from outside: "mapping/recording",
// "localization/sensor", "recording-cards", and "localization/recording" where a second drive is
// named. The last two made are "evaluation" and "compiled-map".
std::vector<PassStep> compile_pipeline(const CompileConfig& config,
                                       ModelSource model = ModelSource::kTrained);

// Judges a finished map by an independent drive. Artifacts taken from outside:
// "evaluation/recording", and from the map "ndt-map", "sites", "predicted-error", "range-table",
// "factor-table". The last two made are "evaluation" and "drive-tracks".
std::vector<PassStep> evaluate_pipeline(const CompileConfig& config);

// What a model learns of one place: the steps of a compile up to "measured-error", and then, where
// asked, those that measure the evaluation drive on the same map, as "evaluation/measured-error".
std::vector<PassStep> measure_pipeline(const CompileConfig& config, bool also_evaluation);

// From "driven-places" to "error-model".
std::vector<PassStep> train_pipeline(const TrainModelOptions& options);

// Opens the recordings that a compile takes and provides them, their sensors and cards. Errors:
// those of open_recording.
Result<void> provide_drives(const CompileConfig& config, ArtifactSet& artifacts);

// Cards of the recordings that were provided, in the order of the configuration's sections.
RecordingCards recording_cards(const CompileConfig& config, const ArtifactSet& artifacts);

// The error model of a finished map (.slmap) or of a model file. Errors: those of read_map, model_of
// and from_bytes.
Result<ErrorModel> read_model(const std::filesystem::path& file);
// Provides it.
Result<void> provide_model(const std::filesystem::path& file, ArtifactSet& artifacts);

// Opens the recording that judges a map and provides it.
Result<void> provide_evaluation(const CompileConfig& config, ArtifactSet& artifacts);

}  // namespace sightline

#pragma once

#include <string>
#include <vector>

#include "compiler/config/compile_config.h"
#include "compiler/pipeline/runner.h"
#include "formats/drive/recording_cards.h"

namespace sightline {

// How a map came to be, as JSON: program version, host, time, command line, the effective
// configuration, what went in and what each pass took. It lies beside the map and never in it,
// because two compiles of the same inputs must give the same map.
std::string provenance_json(const CompileConfig& config,
                            const std::vector<std::string>& command_line,
                            const RecordingCards& recordings,
                            const std::vector<StepReport>& reports);

// The arguments that this process was started with.
std::vector<std::string> command_line();

}  // namespace sightline

#pragma once

#include <string>

#include "compiler/cli/verb.h"

// Flags that stand at several verbs. They are made here so that each means the same everywhere.

namespace sightline {

// -o,--output FILE. `help` names the file and its ending.
Flag output_flag(std::string& file, const std::string& help);
Flag required_output_flag(std::string& file, const std::string& help);

// --force
Flag force_flag(bool& is_forced);

// -q,--quiet
Flag quiet_flag(bool& is_quiet);

// --threads N
Flag threads_flag(int& threads);

// --time-passes
Flag time_passes_flag(bool& time_passes);

// --json-progress[=N]
Flag json_progress_flag(int& descriptor);

// --world WORLD
Flag world_flag(std::string& world);

// --expires TIME
Flag expires_flag(std::string& time);

// --passphrase-file FILE
Flag passphrase_flag(std::string& file);

// A positional that names a compiled map.
Positional map_positional(std::string& file, const std::string& help);

}  // namespace sightline

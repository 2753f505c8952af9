#pragma once

#include "compiler/driver/commands.h"

namespace sightline {

// Parses the command line and runs its verb, which leaves its exit status in `status`; returns that
// of the process. Without arguments it shows where to begin; a verb or flag that does not exist is
// bad-argument and names the nearest one that does.
int run_command_line(CLI::App& app, int argc, char** argv, const int& status);

}  // namespace sightline

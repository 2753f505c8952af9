#pragma once

#include <string>
#include <vector>

#include "compiler/cli/verb.h"

namespace sightline {

// Runs the verb that `words` begin with; returns the exit status of the process. Errors are printed
// on stderr. Without words it prints the help there, which is a usage error; a verb or flag that
// does not exist is bad-argument and names the nearest one that does.
int run_command_line(const Program& program, const std::vector<std::string>& words);

}  // namespace sightline

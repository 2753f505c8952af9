#pragma once

#include <string>
#include <vector>

#include "compiler/cli/verb.h"

namespace sightline {

// Reads the words after a verb and sets the targets of its flags and positionals. `command` is
// the words before them, "sightline compile", for messages. Errors: those of set_flag;
// bad-argument for a flag that does not exist (with the nearest one), a flag without its value, a
// switch with one, a word too many, and flags that cannot be used together.
Result<void> parse_words(const std::string& command, const Verb& verb,
                         const std::vector<std::string>& words);

// Whether --help or -h is among these words, before "--".
bool asks_for_help(const std::vector<std::string>& words);

// Runs the verb that `words` begin with; returns the exit status of the process. Errors are printed
// on stderr. Without words it prints the help there, which is a usage error; a verb or flag that
// does not exist is bad-argument and names the nearest one that does.
int run_command_line(const Program& program, const std::vector<std::string>& words);

}  // namespace sightline

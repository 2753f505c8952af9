#pragma once

#include <string>
#include <vector>

#include "compiler/cli/verb.h"

namespace sightline {

// Reads the words behind a verb and sets the targets of its flags and positionals. `command` is
// what stands before them, "sightline compile", for messages. Errors: those of set_flag;
// bad-argument for a flag that does not exist (with the nearest one), a flag without its value, a
// switch with one, a word too many, and flags that exclude each other.
Result<void> parse_words(const std::string& command, const Verb& verb,
                         const std::vector<std::string>& words);

// Whether --help or -h stands among these words, before "--".
bool asks_for_help(const std::vector<std::string>& words);

// bad-argument: "WHAT; did you mean 'NEAR'?" or, where no known name is near, where to read on.
Error unknown(const std::string& what, const std::string& name,
              const std::vector<std::string>& known, const std::string& command);

}  // namespace sightline

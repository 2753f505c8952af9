#pragma once

#include <string>

#include "compiler/cli/verb.h"

namespace sightline {

constexpr std::size_t kHelpColumns = 100;

// What `sightline --help` prints: how to begin, and every verb with its summary.
std::string help_text(const Program& program);

// What `sightline FAMILY --help` prints: its verbs with their summaries.
std::string help_text(const Program& program, const Family& family);

// What `sightline VERB --help` prints. `command` is "sightline VERB". No line of prose is longer
// than kHelpColumns; examples are not broken.
std::string help_text(const std::string& command, const Verb& verb);

// "-o, --output FILE", "--json-progress[=N]"
std::string flag_title(const Flag& flag);

// What follows from the description of a flag: "required; one of csv, json; default: csv", or "".
std::string facts_of(const Flag& flag);

// "sightline compile [OPTION]... CONFIG"
std::string usage_text(const std::string& command, const Verb& verb);

// sightline(1) as roff with the man macros: every verb with its flags and examples, exit statuses,
// error codes and files.
std::string man_page(const Program& program);

}  // namespace sightline

#pragma once

#include <string>
#include <vector>

#include "compiler/cli/verb.h"

namespace sightline {

// Sets the target of a flag from the words that the command line has for it, which may be none.
// `called` is the flag's name in messages: "--threads" or "MAP".
// Errors: unknown-name for a value that is none of the choices, with the nearest one; bad-value for
// what is no number or lies outside the limits; bad-argument for a flag that is missing or
// repeated.
Result<void> set_flag(const Flag& flag, const std::string& called,
                      const std::vector<std::string>& words);

// The same value in the words of a flag, so that both are read by one function.
Flag as_flag(const Positional& positional);

// What holds without the flag, as help shows it; empty: nothing to show.
std::string default_text(const Flag& flag);

// "a whole number from 0 to 1024", "a number of at least 0", "one of csv, json".
std::string expected_text(const Flag& flag);

}  // namespace sightline

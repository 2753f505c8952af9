#pragma once

#include <string>

#include "compiler/cli/verb.h"

namespace sightline {

// A script to be sourced by bash 4 or later. Needs nothing but its builtins; where a file may stand
// it leaves the word to readline.
std::string bash_completion(const Program& program);

// A completion function for zsh, to be sourced after compinit or put into a folder of $fpath as
// _sightline.
std::string zsh_completion(const Program& program);

}  // namespace sightline

#pragma once

#include <string>

#include "compiler/driver/command_tree.h"

namespace sightline {

// sightline(1) as roff with the man macros: every verb with its flags and examples, exit statuses,
// error codes and files.
std::string man_page(const CommandTree& tree, const std::string& version);

}  // namespace sightline

#pragma once

#include <string>

#include "compiler/cli/verb.h"

namespace sightline {

// sightline(1) as roff with the man macros: every verb with its flags and examples, exit statuses,
// error codes and files.
std::string man_page(const Program& program);

}  // namespace sightline

#pragma once

#include <string>

#include "formats/base/error.h"

namespace sightline {

// The line of a text file that an error names as "line 3, column 9", with a caret below that
// column, each line with its end; empty for an error without such a place and for a line that
// cannot be read again. Fit for a terminal (printable()).
//     cell_m: -1
//             ^
std::string quoted_place(const Error& error);

}  // namespace sightline

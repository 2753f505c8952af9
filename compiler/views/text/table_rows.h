#pragma once

#include <string>

#include "formats/base/result.h"
#include "formats/text/table.h"

// The rows of a table that a person asked for.

namespace sightline {

// Keeps the rows of one site. Error: bad-argument where the table has no column of that name.
Result<void> keep_site(int site, Table& table);

// Keeps the NDs in a box ("x0,y0,x1,y1"). Errors: bad-argument where the table holds no NDs, and
// those of parse_box.
Result<void> keep_box(const std::string& text, Table& table);

}  // namespace sightline

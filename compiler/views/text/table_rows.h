#pragma once

#include <string>
#include <string_view>

#include "formats/base/result.h"
#include "formats/geometry.h"
#include "formats/text/table.h"

// The rows of a table that a person asked for.

namespace sightline {

// Keeps the rows of one site. Error: bad-argument where the table has no column of that name.
Result<void> keep_site(int site, Table& table);

// Adds the columns p_x_world_m and p_y_world_m at the end of a table with places in the map frame
// (columns p_x_m and p_y_m). Any other table is left as it is.
void append_world_columns(const MapFrame& frame, Table& table);

// Keeps the NDs in a box ("x0,y0,x1,y1"). Errors: bad-argument where the table holds no NDs, and
// those of parse_box.
Result<void> keep_box(const std::string& text, Table& table);

// Behind the name of a table of ranges: the table of the looks that take a sample.
inline constexpr std::string_view kLooksSuffix = "-looks";

// Of a table of looks, keeps those that take a sample, with the suffix in its name, or
// else the observation ranges, and then no column "look", which says no more than "range_m";
// without the columns that are then empty. Any other table is left as it is.
enum class KeptLooks { kRanges, kSamples };
void keep_looks(KeptLooks kept, Table& table);
// Moves the rows that keep_looks() would keep of samples, as it would leave them; the other rows
// stay. Of a table of looks.
Table take_samples(Table& table);

}  // namespace sightline

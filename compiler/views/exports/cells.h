#pragma once

#include "formats/reader/reader.h"
#include "formats/text/table.h"

namespace sightline {

// What a map answers by cell of a grid in the plane, whose lines are the multiples of cell_m > 0 in
// world coordinates: the centre of the cell, as high as the nearest site in the plane, and in
// further rows as high as the site on each other level (LaneAsker::levels_world_m); the number of
// the site that answers, how far away it is; for each limit range, probability and whether it is
// unmet, and the same of the look where the map has looks. Rows ascend by x, then y. Cells without
// an answer are left out. `map` is open for the localizer whose errors it holds.
// Errors: those of MapReader::sites() and look().
Result<Table> answers_by_cell(const MapReader& map, double cell_m);

}  // namespace sightline

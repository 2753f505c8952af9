#pragma once

#include <vector>

#include "formats/map/diff/map_diff.h"
#include "formats/map/diff/map_side.h"

namespace sightline {

// A fact "column.NAME" for each column of sites that only one map has or that differs between both:
// its mean on each side and, where both have it, at how many places of the new map it differs from
// the nearest site of the old one within the old map's reach, and by how much at most. Errors:
// checksum-mismatch, too-large, bad-layer.
Result<std::vector<FactDiff>> diff_columns(MapSide& before, MapSide& after);

}  // namespace sightline

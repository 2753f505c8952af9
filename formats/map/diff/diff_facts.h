#pragma once

#include <vector>

#include "formats/map/diff/map_diff.h"
#include "formats/map/diff/map_side.h"

namespace sightline {

// What differs between the manifests of two maps, in the order in which a map is described; figures
// that follow from the layers are left out. The error model and the sensor are compared by digest.
std::vector<FactDiff> diff_facts(const CompiledMap& before, const CompiledMap& after);

// A fact "column.NAME" for each column of sites that only one map has or that differs between both:
// its mean on each side and, where both have it, at how many places of the new map it differs from
// the nearest site of the old one within the old map's reach, and by how much at most. Errors:
// checksum-mismatch, too-large, bad-layer.
Result<std::vector<FactDiff>> diff_columns(MapSide& before, MapSide& after);

}  // namespace sightline

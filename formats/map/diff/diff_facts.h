#pragma once

#include "formats/map/diff/map_diff.h"

namespace sightline {

// What differs between the manifests of two maps, in the order in which a map is described; figures
// that follow from the layers are left out. The error model and the sensor are compared by digest.
std::vector<FactDiff> diff_facts(const CompiledMap& before, const CompiledMap& after);

}  // namespace sightline

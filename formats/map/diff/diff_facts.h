#pragma once

#include "formats/map/diff/map_diff.h"

namespace sightline {

// What the manifests of two maps say differently, in the order in which a map is described; figures
// that follow from the layers are left out. Of the error model its digest, of the sensor and the
// starts of matching a digest where they are too long to read.
std::vector<FactDiff> diff_facts(const CompiledMap& before, const CompiledMap& after);

}  // namespace sightline

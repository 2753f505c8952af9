#pragma once

#include <string>

#include "formats/geodesy.h"
#include "passes/weakness/find_weakness.h"

namespace sightline {

// All that was found, as schemas/weak.schema.json describes it; positions in world coordinates, m.
std::string to_json(const Weakness& weakness, const Sites& sites);

// For a geographic information system, as to_geojson() of a map: each stretch is a line along its
// sites (a Point where it has one), each place for a board a Point, distinguished by the property
// "kind". Error: bad-argument (a place is no point of the world named).
Result<std::string> to_geojson(const Weakness& weakness, const Sites& sites, const World& world);

}  // namespace sightline

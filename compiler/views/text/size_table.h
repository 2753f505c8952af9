#pragma once

#include <string>

#include "formats/map/map_summary.h"

namespace sightline {

// What the bytes of a map are: a row for each part, largest first, with its bytes for each
// kilometre of route, its share of the file, and what a map without it cannot do. Rows add up to
// the file. route_m: 0 where there is no route, then bytes are of the whole file.
std::string size_table(const MapSummary& summary, double route_m);

}  // namespace sightline

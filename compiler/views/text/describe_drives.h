#pragma once

#include <string>

#include "formats/surroundings/tile_drives.h"

namespace sightline {

// Of a map of several drives, a line for each: when it was, and how many tiles are from it.
std::string describe_drives(const TileDrives& tiles);

}  // namespace sightline

#pragma once

#include <string>

#include "formats/map/compiled_map.h"
#include "formats/map/map_reader.h"
#include "formats/surroundings/tile_drives.h"

namespace sightline {

// For people: what the map covers, how far to look for each limit, what is promised, and
// what the model is worth. Several lines, ends in a newline.
std::string describe(const CompiledMap& map);

// A line that stands before figures of a map's ranges where another localizer made them than the
// one whose errors the map predicts; empty where both are one.
std::string judged_by(const LocalizerProfile& of_map, const LocalizerProfile& judging);

// For people: format, sizes and digests of the file.
std::string describe(const MapSummary& summary);

// For people: the digest by which maps name this model, and its card.
std::string describe(const ByFamily<ErrorModel>& model);

// Of a map of several drives, a line for each: when it was, and how many tiles are from it.
std::string describe_drives(const TileDrives& tiles);

}  // namespace sightline

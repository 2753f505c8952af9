#pragma once

#include <filesystem>
#include <string_view>

#include "formats/base/result.h"
#include "formats/drive/route.h"
#include "formats/geodesy.h"

namespace sightline {

// Reads the lines that a map is annotated along, in the coordinates of that map:
//
//   .osm            Lanelet2: the centre line of each lanelet that vehicles drive, in its
//                   direction, in both where it is no one-way street. Places are the nodes' local_x
//                   and local_y where `world` is local, else latitude and longitude put into
//                   `world`; heights are the tag ele.
//   .geojson .json  every LineString and MultiLineString: longitude and latitude put into `world`,
//                   or the map's own coordinates where it is local
//   .csv            x, y and z or none, one point a line, with a head of their names or without; a
//                   column `line`, or an empty line, sets one line apart from the next
//   .tum .txt       a trajectory, t x y z qx qy qz qw: where a vehicle was. A step of more than 5 m
//                   begins another line.
//
// Errors: file-not-found, cannot-read, unsupported-format (another ending; degrees where `world` is
// local), malformed-text with the line or element (also a place that is none on Earth, lines of
// more than 10000 km), missing-field (no line; no lanelet for vehicles; nodes without a place),
// bad-argument (a place outside `world`), and those of read_poses.
Result<Route> read_route(const std::filesystem::path& path, const World& world);

}  // namespace sightline

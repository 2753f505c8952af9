#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/foreign/text/geodetic_fix.h"
#include "formats/foreign/text/pose_row.h"

// Poses of a satellite receiver or an inertial unit in degrees.

namespace sightline {

// Whether a path holds such poses and not those of read_poses(): a folder, a first line that begins
// with $ (NMEA), or one that names columns of latitude and longitude.
bool is_geodetic(const std::filesystem::path& path);

// Of what is_geodetic() says. A folder is KITTI's oxts: the files of data/ with timestamps.txt, or
// data/ itself. Errors: file-not-found, cannot-open, cannot-read, malformed-pose (with the line),
// missing-field (no latitude or longitude), time-runs-backwards.
Result<GeodeticTrack> read_geodetic_track(const std::filesystem::path& path);

// The same poses in a world, which for "local" is that of enu_world_name() at the first; a warning
// then names it. Where no heading is given it is the direction of travel. Errors: malformed-pose
// (none at all, or neither a heading nor a metre of way), bad-argument (no place of the world).
struct TrackInWorld {
  std::vector<PoseRow> rows;
  std::vector<std::string> warnings;
};
Result<TrackInWorld> in_world(const GeodeticTrack& track, const std::string& world,
                              const std::string& path);

}  // namespace sightline

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/geodesy.h"

namespace sightline {

// A pose of a satellite receiver or an inertial unit. Angles as ROS has them (REP 103):
// x forward, y left, z up; yaw from east, counter-clockwise; pitch positive with the nose down.
struct GeodeticFix {
  std::optional<std::int64_t> stamp_ns;
  Geodetic at;
  std::optional<double> yaw_rad;
  double pitch_rad = 0.0;
  double roll_rad = 0.0;
};

struct GeodeticTrack {
  std::vector<GeodeticFix> fixes;     // times ascend where there are any
  std::vector<std::string> warnings;  // what was skipped or assumed
};

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

// The forms that read_geodetic_track() knows; not for other folders.

// A first line that names columns: latitude and longitude in degrees, height in metres above the
// ellipsoid, time (parse_stamp_ns), roll and pitch, and `yaw` (from east, counter-clockwise; pitch
// then positive with the nose down) or `heading`, `azimuth` or `course` (from north, clockwise;
// pitch then positive with the nose up). Angles in degrees but for names that end in rad.
Result<GeodeticTrack> parse_gnss_csv(const FileBytes& file);
bool names_latitude_and_longitude(std::string_view line);

// GGA makes the places, RMC and ZDA the date, PASHR and HDT the heading. Heights are above the
// ellipsoid: altitude plus the separation of the geoid. Sentences with a wrong checksum and places
// without a fix are skipped, with a warning.
Result<GeodeticTrack> parse_nmea(const FileBytes& file);

// Error: malformed-pose where latitude or longitude are not on Earth, or a number is not finite.
Result<void> check_fix(const FileBytes& file, std::size_t line, const GeodeticFix& fix);

}  // namespace sightline

#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/geodetic_fix.h"

// The forms that read_geodetic_track() knows; not for other folders.

namespace sightline {

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

// KITTI's folder oxts, or data/ in it.
Result<GeodeticTrack> read_oxts(const std::filesystem::path& folder);

// "2011-09-26" and "13:02:25.594360375", UTC. nullopt: none.
std::optional<std::int64_t> parse_date_time_ns(std::string_view date, std::string_view time);

// Error: malformed-pose where latitude or longitude are not on Earth, or a number is not finite.
Result<void> check_fix(const FileBytes& file, std::size_t line, const GeodeticFix& fix);

}  // namespace sightline

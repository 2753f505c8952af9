#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/sensor_profile.h"

namespace sightline {

// Whether a value of `sensor` names a file and not a built-in profile: by its ending, .yaml, .yml,
// .csv or .json.
bool is_sensor_file(std::string_view name);

// A LiDAR that is not built in. .yaml, one "key: value" a line: `beams_deg: [-15, -13, ...]`, or
// `beams` with `lowest_beam_deg` and `highest_beam_deg`; and, where they differ from generic-16,
// `name`, `azimuth_step_deg`, `azimuth_view_deg`, `min_range_m`, `max_range_m`, `height_m`. .csv:
// parse_beam_table. .json: Ouster's metadata. Beams of one elevation are one. The profile is valid.
// Errors: file-not-found, cannot-read, malformed-text (with the line), unknown-key, missing-key,
// bad-value.
Result<SensorProfile> read_sensor_file(const std::filesystem::path& path);
// The same of what the file holds.
Result<SensorProfile> parse_sensor_file(std::string_view text, const std::filesystem::path& path);

// A line of a table of beams, as Hesai's angle correction files are.
struct BeamRow {
  double elevation_deg = 0.0;
  std::optional<double> azimuth_deg;  // beside that of the head, clockwise; nothing: no column
  std::optional<int> channel;         // from 1; nothing: no column
};

// A first line that names columns (among them one that begins with "elevation"; "azimuth", and
// "channel" or "laser" where they are there), then one beam a line. At most 1024 beams. Errors:
// malformed-text (with the line).
Result<std::vector<BeamRow>> parse_beam_table(std::string_view text, std::string_view file);

}  // namespace sightline

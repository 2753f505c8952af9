#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

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

#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// What config.xml of an Apollo NDT map says of its nodes.
struct ApolloConfig {
  std::uint32_t node_columns = 0;  // cells of a node along x
  std::uint32_t node_rows = 0;     // along y
  double min_x_m = 0.0;            // where node 0 begins, easting
  double min_y_m = 0.0;
  bool is_compressed = true;
  std::vector<double> cells_m;    // edge of a cell along x and y, by number of the resolution
  std::vector<double> heights_m;  // along z
};

// Errors: malformed-text (no XML, or a number that is none), missing-field, unsupported-format
// (another map of Apollo's than map_ndt, sizes beyond reason).
Result<ApolloConfig> parse_apollo_config(std::string_view text, const std::string& file);

}  // namespace sightline

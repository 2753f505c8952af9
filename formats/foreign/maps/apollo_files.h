#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/maps/foreign_maps.h"

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

// Which node a file is, as its folders name it and its header repeats.
struct ApolloNodeIndex {
  std::uint32_t resolution = 0;
  std::int32_t zone = 0;  // of UTM, negative in the south
  std::uint32_t m = 0;    // number of the node along y (northing)
  std::uint32_t n = 0;    // along x (easting)
  friend bool operator==(const ApolloNodeIndex&, const ApolloNodeIndex&) = default;
};

struct ApolloNode {
  std::vector<ForeignNd> nds;  // in the order of the file; two may have one key
  std::uint64_t single_point_count = 0;
  std::uint64_t damaged_count = 0;  // cells of numbers that no points have, left out
  std::uint64_t point_count = 0;
};

// A node of Apollo's NDT map (modules/localization/msf/local_pyramid_map/ndt_map of
// github.com/ApolloAuto/apollo): a header of 20 bytes and cells, packed by zlib.
// schemas/definitions.md has covariances, heights and the cell of an ND. Errors: truncated-scan
// (ends early, or cannot be unpacked), malformed-header (another node than `index`, contradicting
// sizes, bytes behind the end), unsupported-format (more than 64 cells a column or 1 GiB).
Result<ApolloNode> parse_apollo_node(std::span<const std::byte> bytes, const ApolloConfig& config,
                                     const ApolloNodeIndex& index, const std::string& file);

}  // namespace sightline

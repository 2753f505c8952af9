#pragma once

#include <filesystem>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/maps/foreign_maps.h"

namespace sightline {

// Whether a folder is Apollo's NDT map: config.xml beside a folder map/. Or its config.xml.
bool is_apollo_map(const std::filesystem::path& path);

// All nodes of Apollo's NDT map, `threads` (0: all) at a time, in a zone of UTM. Reads the
// resolution of the largest cells of at most 2 m, else the finest; of two cells whose means share a
// cell of the grid the one of more points; both with a warning. Errors: file-not-found,
// empty-directory (no node), unsupported-format (cells that are no cubes, another grid than the
// world's, several zones), and those of parse_apollo_config and parse_apollo_node.
Result<ForeignNds> open_apollo_map(const std::filesystem::path& path, int threads);

// config.xml and the nodes that are read, in the order of their names; no node is opened.
Result<std::vector<std::filesystem::path>> list_apollo_map(const std::filesystem::path& path);

}  // namespace sightline

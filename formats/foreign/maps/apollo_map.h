#pragma once

#include <filesystem>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/maps/foreign_maps.h"

namespace sightline {

// Whether a folder is Apollo's NDT map: config.xml beside a folder map/. Or its config.xml.
bool is_apollo_map(const std::filesystem::path& path);

// Apollo's NDT map, all nodes of it, `threads` (0: all) at a time: cells with means and covariances
// in a zone of UTM. Of several resolutions that of the largest cells of at most 2 m is read, or
// else the finest, and a warning says so. Two cells whose means share one cell of the grid become
// that of more points, and a warning counts them. Errors: file-not-found, empty-directory (no
// node), unsupported-format (cells that are no cubes, a grid that is not one with the world's,
// nodes of several zones), and those of parse_apollo_config and parse_apollo_node.
Result<ForeignNds> open_apollo_map(const std::filesystem::path& path, int threads);

// config.xml and the nodes that are read, in the order of their names; no node is opened.
Result<std::vector<std::filesystem::path>> list_apollo_map(const std::filesystem::path& path);

}  // namespace sightline

#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/annotation/site_column.h"
#include "formats/reader/map_container.h"

// Columns of sites as they are in the file: an optional section each (schemas/map_format.md).

namespace sightline {

// "column.clearance_m"
std::string column_section(std::string_view name);
// float32, little-endian, one a site.
std::vector<std::byte> encode_column(const SiteColumn& column);
// Whether these bytes are the column that the map's manifest names. Error: digest-mismatch.
Result<void> check_column(const MapContainer& container, std::string_view name,
                          std::span<const std::byte> raw);
// Fills the values. Error: bad-layer (not one of 4 bytes for each site).
Result<void> decode_column(std::span<const std::byte> raw, std::size_t site_count,
                           SiteColumn& column);

// At most 256, each valid, of these sites, names ascending. Error: invalid-artifact.
Result<void> validate_columns(const std::vector<SiteColumn>& columns, std::size_t site_count);

}  // namespace sightline

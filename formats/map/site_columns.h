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
// float32, little-endian, or the number of a step, one byte; one a site.
std::vector<std::byte> encode_column(const SiteColumn& column);
// Whether these bytes are the column that the map's manifest names. Error: digest-mismatch.
Result<void> check_column(const MapContainer& container, std::string_view name,
                          std::span<const std::byte> raw);
// Fills the values, of a column whose steps are known. Error: bad-layer (not one for each site, or
// no such step).
Result<void> decode_column(std::span<const std::byte> raw, std::size_t site_count,
                           SiteColumn& column);

// At most 256, each valid, of these sites, names ascending. Error: invalid-artifact.
Result<void> validate_columns(const std::vector<SiteColumn>& columns, std::size_t site_count);

}  // namespace sightline

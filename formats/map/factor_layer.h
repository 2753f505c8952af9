#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/sites.h"
#include "formats/surroundings/ndt_map.h"

// The map factors as engineers find them in a map (schemas/map_format.md): an optional layer of
// each tile with sites, and an optional section with the factors' names. No vehicle needs them.

namespace sightline {

inline constexpr std::string_view kFactorLayer = "factors";
inline constexpr std::uint32_t kFactorLayerVersion = 1;
inline constexpr std::string_view kFactorNames = "factor-names";
inline constexpr std::uint32_t kFactorNamesVersion = 1;
// The same, of the looks that take a sample.
inline constexpr std::string_view kSampleFactorLayer = "look-factors";
inline constexpr std::string_view kSampleFactorNames = "look-factor-names";
inline constexpr std::uint64_t kMostFactors = 256;

// `sites` are those of one tile, ascending. Exact.
std::vector<std::byte> encode_factor_layer(const FactorTable& factors,
                                           std::span<const std::uint32_t> sites);

// The same of a table that holds these sites alone, in their order.
std::vector<std::byte> encode_factor_rows(const FactorTable& of_sites,
                                          std::span<const std::uint32_t> sites);

// Fills the rows of the layer's sites in a table that has its ranges, names and size already;
// `is_filled` marks which sites are. Errors: bad-layer (a size that its rows do not need),
// bad-order.
Result<void> decode_factor_layer(std::span<const std::byte> raw, std::uint64_t row_count,
                                 FactorTable& factors, std::vector<bool>& is_filled);

// Each name ends in a line feed.
std::vector<std::byte> encode_factor_names(const FactorTable& factors);
// Error: bad-layer where there are not as many names as the table has.
Result<void> decode_factor_names(std::span<const std::byte> raw, FactorTable& factors);

}  // namespace sightline

#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "formats/base/result.h"
#include "formats/reader/opened_map.h"

namespace sightline {

// `file` must start at an address that is a multiple of 8. Reads the header, the trailer and the
// manifest, and nothing else but where an unknown required feature must be named.
// `program` is the format of who reads; another one is for tests.
// Errors: those of decode_header; future-version, old-version, unknown-required-feature (naming
// it), out-of-bounds, checksum-mismatch, bad-manifest, bad-order.
Result<MapFront> open_front(std::span<const std::byte> file,
                            FormatVersion program = kFormatVersion);

// The same of a file that may have lost its end or its trailer.
Result<MapFront> open_front_alone(std::span<const std::byte> file);

// Reads the directory as well. Errors: out-of-bounds, checksum-mismatch, bad-manifest, bad-order,
// unknown-required-feature, bad-layer, too-large.
Result<MapContainer> open_directory(const MapFront& front);

// Both; optional things it does not know are skipped.
// Errors: the same and bad-layer, too-large.
Result<MapContainer> open_container(std::span<const std::byte> file);

// Index of a tile in the directory.
std::optional<std::uint32_t> find_tile(const MapContainer& container, std::int32_t x,
                                       std::int32_t y);

// A layer of a tile, a section of the map; nullptr where there is none of this name.
const schema::Block* find_layer(const MapContainer& container, std::uint32_t tile,
                                std::string_view name);
const schema::Block* find_section(const MapContainer& container, std::string_view name);

// The bytes of a block as they lie in the file, unchecked.
std::span<const std::byte> located_bytes(const MapContainer& container, const schema::Block& block);
// The same after their checksum. Error: checksum-mismatch, at the block's byte.
Result<std::span<const std::byte>> stored_bytes(const MapContainer& container,
                                                const schema::Block& block);

}  // namespace sightline

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/surroundings/tile_drives.h"

// Which drives, and so which days, each tile is from: an optional section of a map of several
// drives (schemas/map_format.md). No vehicle needs it.

namespace sightline {

inline constexpr std::string_view kDrivesSection = "drives";
inline constexpr std::uint32_t kDrivesSectionVersion = 1;

std::vector<std::byte> encode_drives(const TileDrives& tiles);
// Errors: bad-layer (a size that its rows do not need), invalid-artifact.
Result<TileDrives> decode_drives(std::span<const std::byte> raw, std::uint64_t row_count);

}  // namespace sightline

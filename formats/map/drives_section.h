#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/surroundings/tile_drives.h"

// Which drives, and so which days, each tile is from, and which found nothing new there: an
// optional section of a map of several drives (schemas/map_format.md). No vehicle needs it.

namespace sightline {

inline constexpr std::string_view kDrivesSection = "drives";
// That is written.
inline constexpr std::uint32_t kDrivesSectionVersion = ArtifactTraits<TileDrives>::kVersion;
// Whether decode_drives reads a version.
constexpr bool knows_drives_section(std::uint32_t version) {
  return version >= 1 && version <= kDrivesSectionVersion;
}

std::vector<std::byte> encode_drives(const TileDrives& tiles);
// Errors: bad-layer (a size that its rows do not need), invalid-artifact.
Result<TileDrives> decode_drives(std::span<const std::byte> raw, std::uint32_t version,
                                 std::uint64_t row_count);

}  // namespace sightline

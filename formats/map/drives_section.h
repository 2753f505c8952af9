#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/recording_cards.h"
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

// The recordings that the map and its errors were made from, with a sketch of each scan: another
// optional section, by which `evaluate` recognizes a drive that the map was made from.
inline constexpr std::string_view kRecordingsSection = "recordings";
inline constexpr std::uint32_t kRecordingsSectionVersion = 1;

std::vector<std::byte> encode_recordings(const RecordingCards& recordings);
// Errors: bad-layer (a size that its rows do not need), invalid-artifact.
Result<RecordingCards> decode_recordings(std::span<const std::byte> raw, std::uint64_t row_count);

}  // namespace sightline

#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "formats/base/result.h"
#include "formats/map/diff/map_diff.h"

namespace sightline {

// Both maps are opened and checked as a vehicle does, and the checksum of every block that is read
// (verify checks the rest). The old map's answer at a site of the new map is that of its nearest
// site within its reach, on a tie the lower number. NDs are compared by their cell in the world;
// the facts say where the maps' grids do not coincide. Errors: those of open_container(),
// bad-layer, checksum-mismatch, bad-order; of paths also file-not-found, cannot-open, cannot-read.
Result<MapDiff> diff_maps(const std::filesystem::path& before, const std::filesystem::path& after,
                          const MapDiffOptions& options);
// The bytes of two files, at addresses that are multiples of 8.
Result<MapDiff> diff_maps(std::span<const std::byte> before, std::span<const std::byte> after,
                          const MapDiffOptions& options);

}  // namespace sightline

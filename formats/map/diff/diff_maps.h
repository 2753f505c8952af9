#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "formats/base/result.h"
#include "formats/map/diff/map_diff.h"

namespace sightline {

// Both maps are opened and checked as a vehicle would, and every block that is read has the
// checksum it should; verify checks the rest. The old map's answer at a site of the new map is that
// of its site nearest to it, at most its reach away, as a vehicle would look it up; of sites
// equally near the one with the lower number. NDs are compared by their cell in the world; where
// the maps' grids do not coincide that is said in the facts. Errors: those of open_container(),
// bad-layer, checksum-mismatch, bad-order; of paths also file-not-found, cannot-open, cannot-read.
Result<MapDiff> diff_maps(const std::filesystem::path& before, const std::filesystem::path& after,
                          const MapDiffOptions& options);
// The bytes of two files, at addresses that are multiples of 8.
Result<MapDiff> diff_maps(std::span<const std::byte> before, std::span<const std::byte> after,
                          const MapDiffOptions& options);

}  // namespace sightline

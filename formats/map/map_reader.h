#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "formats/map/compiled_map.h"
#include "formats/map/map_summary.h"

namespace sightline {

// Reads and checks every byte: header, trailer, manifest, directory, padding, the checksum and
// digest of every block, the digests of tiles and map, and every invariant of the artifacts. What
// is optional and unknown is skipped once its checksum holds.
// The error has the place of the first fault. Errors: those of open_container(); digest-mismatch,
// checksum-mismatch, bad-layer, bad-order, invalid-artifact; of a path also file-not-found,
// cannot-open, cannot-read.
Result<CompiledMap> read_map(const std::filesystem::path& path);
Result<CompiledMap> read_map(std::span<const std::byte> file);

// The same checks; without NDs, which are most of a map, and with what verify_map() finds.
struct CheckedMap {
  CompiledMap map;  // its NDs are empty
  MapSummary summary;
};
Result<CheckedMap> read_map_without_nds(const std::filesystem::path& path);

// The same checks, and what was found.
Result<MapSummary> verify_map(const std::filesystem::path& path);
Result<MapSummary> verify_map(std::span<const std::byte> file);

}  // namespace sightline

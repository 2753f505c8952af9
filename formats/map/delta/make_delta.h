#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "formats/map/delta/delta_format.h"

namespace sightline {

struct DeltaOptions {
  // Sends changed layers as they are packed in the map, so that vehicles with another version of
  // zstd can apply the delta too; else packed against the old layer, which is smaller.
  bool is_portable = false;
};

// The delta that makes `result` of `base`; both are whole maps at addresses that are multiples of 8
// (schemas/delta_format.md). The same maps give the same bytes for the same version of zstd.
// Errors: those of open_container(); too-large for a map that a delta cannot describe.
Result<std::vector<std::byte>> make_delta(std::span<const std::byte> base,
                                          std::span<const std::byte> result,
                                          const DeltaOptions& options);

// Of files, after every checksum and digest of both maps. Error: also file-not-found, cannot-open,
// cannot-read, digest-mismatch.
Result<std::vector<std::byte>> make_delta(const std::filesystem::path& base,
                                          const std::filesystem::path& result,
                                          const DeltaOptions& options);

// Reads the header and the trailer of a map, no more. Errors: those of decode_header().
Result<MapIdentity> identity_of(std::span<const std::byte> file);

}  // namespace sightline

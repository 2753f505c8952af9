#pragma once

#include <filesystem>

#include "formats/base/hash.h"
#include "formats/base/result.h"

namespace sightline {

// Reads a whole map, checks every checksum, the digests of all that a vehicle acts on, of tiles and
// of the map, and the zeros between blocks, and returns the root digest. verify_map() also checks
// what layers contain. Memory: the largest layer. Errors: those of open_container(),
// checksum-mismatch, digest-mismatch, out-of-bounds, bad-layer; file-not-found, cannot-open,
// cannot-read.
Result<Digest> check_map_digests(const std::filesystem::path& path);

}  // namespace sightline

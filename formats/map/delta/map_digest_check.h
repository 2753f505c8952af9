#pragma once

#include <filesystem>

#include "formats/base/hash.h"
#include "formats/base/result.h"

namespace sightline {

// Reads a whole map and checks that it is the one that its root digest names: every checksum, the
// digests of all that a vehicle acts on, those of tiles and map, and the zeros between blocks; not
// what the layers say, which verify_map() does. Memory: the largest layer, whatever the map's size.
// Returns the root digest.
// Errors: those of open_container(), checksum-mismatch, digest-mismatch, out-of-bounds, bad-layer;
// file-not-found, cannot-open, cannot-read.
Result<Digest> check_map_digests(const std::filesystem::path& path);

}  // namespace sightline

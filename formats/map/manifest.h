#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/map/compiled_map.h"

namespace sightline {

namespace schema {
struct Manifest;
}

// Everything of a map that is not per tile, as a FlatBuffer of schemas/map.fbs.
std::vector<std::byte> encode_manifest(const CompiledMap& map);
// The same of a map whose NDs, so many, are elsewhere.
std::vector<std::byte> encode_manifest(const CompiledMap& map, std::uint64_t nd_count);

// Fills all but NDs, sites, predictions, choices, the values of columns and the model's bytes. The
// manifest has been checked (check_manifest). Error: bad-manifest.
Result<void> decode_manifest(const schema::Manifest& manifest, CompiledMap& map);

}  // namespace sightline

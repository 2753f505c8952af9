#pragma once

#include <string>

#include "formats/base/result.h"
#include "formats/reader/opened_map.h"

// What must hold of a manifest and a directory before anything in them is used. FlatBuffers'
// verifier has shown by then that no reference leaves its buffer, and nothing more.

namespace sightline {

// Finite and positive lengths, ascending ranges and limits, looks that take a sample, counts within
// bounds.
// Errors: bad-manifest, bad-order.
Result<void> check_manifest(const schema::Manifest& manifest);

// What the answers of a map are for, by its checked manifest.
AnswerShape answer_shape(const schema::Manifest& manifest);

// Features by name. Error: unknown-required-feature.
Result<void> check_features(const FileHeader& header, const schema::Directory& directory);

// Tiles and names ascend, blocks are aligned, ascend through the file without overlap and stay
// between manifest and directory; required ones are known and have the size their rows need.
// Errors: out-of-bounds, bad-order, bad-layer, too-large, unknown-required-feature.
Result<void> check_directory(const MapContainer& container);

// "tile 3,-1"
std::string tile_place(std::int32_t x, std::int32_t y);

}  // namespace sightline

#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/map/compiled_map.h"

namespace sightline {

struct Recovered {
  CompiledMap map;  // valid; that of the file where nothing was lost
  // What was left out and why, a sentence each.
  std::vector<std::string> lost;
};

// The intact part of a damaged or truncated file: each tile whose required layers match their
// checksums and digests; the factors and the error model where all of their blocks do. Tiles are
// found by the directory, or where that is lost by their layers "contents". Where sites are lost,
// the others are numbered anew, a run ends at each gap, measured figures are left out, and the
// version ends in "recovered": it is another map, with another root digest. Header and manifest
// must be intact. `file` starts at a multiple of 8. Errors: those of the header and the manifest;
// truncated-file where no site is left.
Result<Recovered> recover_map(std::span<const std::byte> file);

}  // namespace sightline

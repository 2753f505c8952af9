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

// A copy of a map whose blocks stay packed as they are, so that no digest but those of what is left
// out changes, and no signature either.

struct Repacked {
  std::vector<std::byte> file;
  std::vector<std::string> actions;  // what was done, a sentence each
};

// The map without what only engineers need: the layers "factors" and "debug", the sections
// "factor-names" and "error-model", and of the section "recordings" the sketches of scans. What is
// optional and unknown stays. The map is checked as a whole first: damage is not copied. `file`
// starts at a multiple of 8. Errors: those of verify_map().
Result<Repacked> strip_map(std::span<const std::byte> file);

}  // namespace sightline

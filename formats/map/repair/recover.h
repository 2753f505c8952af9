#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/map/compiled_map.h"

namespace sightline {

struct Recovered {
  CompiledMap map;  // valid; the same where nothing was lost
  std::vector<std::string>
      lost;  // what was not taken over and why, a sentence each; empty: nothing
};

// What a damaged or truncated file still holds: each tile whose required layers all match their
// checksums and digests, the error model and the factors where all of them do. The tiles are those
// of the directory, or where that is lost, those that tell their own contents. Where sites are lost
// the rest are numbered anew, a run ends at each gap, what was measured is no longer told, and the
// version says "recovered": it is another map, with another root digest. Header and manifest must
// be whole. `file` starts at a multiple of 8. Errors: those of the header and the manifest;
// truncated-file where no site is left.
Result<Recovered> recover_map(std::span<const std::byte> file);

}  // namespace sightline

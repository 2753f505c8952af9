#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "formats/base/hash.h"

namespace sightline {

// Makes sizes, checksums and digests of a damaged map fit its bytes again, as far as its parts can
// still be found, so that a fuzzer reaches what lies behind them. Changes nothing else. `root` is a
// digest of the whole map to write in place of the right one.
void repair_map(std::span<std::byte> file, const std::optional<Digest>& root = {});

}  // namespace sightline

#pragma once

#include <cstddef>
#include <span>

namespace sightline {

// Makes sizes, checksums and digests of a damaged map fit its bytes again, as far as its parts can
// still be found, so that a fuzzer reaches what lies behind them. Changes nothing else.
void repair_map(std::span<std::byte> file);

}  // namespace sightline

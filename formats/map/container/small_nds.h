#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "formats/base/result.h"
#include "formats/map/container/small_nd.h"
#include "formats/reader/map_layout.h"

// The codec "nds": a layer "ndt" whose NDs are all small (small_nd.h), a byte for each number.

namespace sightline {

NdRow load_nd_row(std::span<const std::byte> raw, const NdtLayout& layout, std::uint64_t row);
void store_nd_row(const NdRow& nd, const NdtLayout& layout, std::uint64_t row,
                  std::vector<std::byte>& raw);

// None where an ND of the layer is not small.
std::optional<std::vector<std::byte>> pack_small_nds(std::span<const std::byte> raw,
                                                     std::uint64_t row_count, double cell_m);
// The layer as it was, of raw_size bytes. Errors: bad-layer, too-large.
Result<std::vector<std::byte>> unpack_small_nds(std::span<const std::byte> stored,
                                                std::uint64_t row_count, std::uint64_t raw_size);

}  // namespace sightline

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/result.h"
#include "formats/map/container/byte_planes.h"

// The codec "columns": a layer of columns, each as the differences from row to row in planes of
// bytes. For figures along a street, which change little from site to site.

namespace sightline {

// `columns`: all of the layer, in their order; each begins at a multiple of kAlignment.
std::vector<std::byte> pack_columns(std::span<const std::byte> raw,
                                    std::span<const ArrayShape> columns);
// The layer as it was, of raw_size bytes. Errors: bad-layer, too-large.
Result<std::vector<std::byte>> unpack_columns(std::span<const std::byte> stored,
                                              std::uint64_t row_count, std::uint64_t raw_size);

}  // namespace sightline

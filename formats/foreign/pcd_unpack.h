#pragma once

#include <cstdint>
#include <vector>

#include "formats/foreign/pcd_header.h"

namespace sightline {

// The points of a binary or binary_compressed body, one after the other, header.point_size bytes
// each. The caller has checked that the body has the size that the header asks for.
// Error: truncated-scan where the compressed stream does not unpack to that size.
Result<std::vector<std::uint8_t>> unpack_pcd_body(const FileBytes& file, const PcdHeader& header);

}  // namespace sightline

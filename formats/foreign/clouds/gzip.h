#pragma once

#include <vector>

#include "formats/foreign/clouds/cloud_parsers.h"

namespace sightline {

bool is_gzip(std::string_view text);

// What a gzip file holds. Errors: truncated-scan (cut or damaged), unsupported-format (unpacks to
// more than 1 GiB: no single scan is so large).
Result<std::vector<std::byte>> unpack_gzip(const FileBytes& file);

}  // namespace sightline

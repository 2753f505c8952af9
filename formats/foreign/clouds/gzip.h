#pragma once

#include <vector>

#include "formats/foreign/text/file_bytes.h"

namespace sightline {

bool is_gzip(std::string_view text);

// What all members of a gzip file hold, one after the other. Errors: truncated-scan (cut or
// damaged), malformed-header (bytes behind the last member that are no padding), unsupported-format
// (unpacks to more than 1 GiB: no single scan is so large).
Result<std::vector<std::byte>> unpack_gzip(const FileBytes& file);

}  // namespace sightline

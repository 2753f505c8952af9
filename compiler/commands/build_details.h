#pragma once

#include <string>

namespace sightline {

// What --version prints beside the version, a line each: commit; versions of the formats that are
// written, the configuration's by the beginning of its schema's SHA-256; kernels of the matcher
// that this processor has, the one in use first; libraries of the build. None of it enters a map.
std::string build_details();

}  // namespace sightline

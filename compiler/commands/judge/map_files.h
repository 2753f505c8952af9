#pragma once

#include <string>
#include <vector>

#include "formats/base/result.h"

// The maps that a command line names.

namespace sightline {

// Files as they are named; of a folder its maps (.slmap), by name. Errors: empty-directory (a
// folder without a map), cannot-read.
Result<std::vector<std::string>> map_files(const std::vector<std::string>& named);

// The world of the first file that can be opened. Errors: those of MapReader::open for the first
// file, where none can.
Result<std::string> world_of(const std::vector<std::string>& map_files);

}  // namespace sightline

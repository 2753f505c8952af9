#pragma once

#include <filesystem>

#include "formats/base/files/atomic_file.h"

namespace sightline {

// Whether a file may be written there, asked before hours of work rather than after them: as
// check_output(), and whether its folder, or the deepest one on the way to it that exists, is one
// and lets files be made. A configuration or a recording (a bag, a capture) is never replaced. An
// empty path is fine: nothing is written. Errors: those of check_output(); cannot-write.
Result<void> try_output(const std::filesystem::path& path, IfExists if_exists);

}  // namespace sightline

#pragma once

#include <filesystem>
#include <vector>

#include "formats/annotation/outside_errors.h"
#include "formats/base/result.h"

namespace sightline {

// Reads the CSV of import-errors: a line of names, then one error a line. Columns in any order:
// `scan` (0-based, in the recording), `look` (or `range`; m), `start` (0, 1, ...) and `error` (m,
// 3D distance from the reference); "_m" may follow a name of metres. Blank lines and lines that
// begin with # are skipped. Result ascending (scan, look, start). Errors, with file and line:
// file-not-found, cannot-open, cannot-read; missing-field (a column); malformed-text (a column
// twice or unknown, another number of words, no finite number at least 0, a look of 0, the same
// scan, look and start twice, no error at all).
Result<std::vector<OutsideError>> read_outside_errors(const std::filesystem::path& path);

}  // namespace sightline

#pragma once

#include <filesystem>
#include <vector>

#include "formats/annotation/outside_errors.h"
#include "formats/base/result.h"

namespace sightline {

// Reads the CSV of import-errors: a line of names, then one error a line. Columns in any order:
// `scan` (0-based), `look` (or `range`; m), `start` (0, 1, ...) and `error` (m, 3D distance from
// the reference), perhaps with "_m". Blank lines and those that begin with # are skipped. Result
// ascending (scan, look, start). Errors, with file and line: file-not-found, cannot-open,
// cannot-read, missing-field (a column), malformed-text (also a row given twice, or no error at
// all).
Result<std::vector<OutsideError>> read_outside_errors(const std::filesystem::path& path);

}  // namespace sightline

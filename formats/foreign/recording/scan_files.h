#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// Runs of digits compare as numbers, so that 2 comes before 10; ties by plain text.
bool natural_less(std::string_view a, std::string_view b);

// The scans of a folder in natural order: files with a readable ending (is_scan_ending), all
// of one kind. Hidden files and files of other kinds are no scans.
// Errors: file-not-found (no such folder, or a link among the scans leads nowhere), cannot-open,
// cannot-read (no regular file), empty-directory, mixed-formats, unsupported-format (also of a file
// in place of the folder; says how to convert it).
Result<std::vector<std::filesystem::path>> list_scan_files(const std::filesystem::path& folder);

// The last run of digits in a scan's name ("scan_000012.pcd": 12), or nothing.
std::optional<std::int64_t> scan_number(const std::filesystem::path& file);

// The time that a scan's name is ("1567410201745204736.pcd", "1567410201.745204.bin"), or nothing.
std::optional<std::int64_t> scan_stamp_ns(const std::filesystem::path& file);

}  // namespace sightline

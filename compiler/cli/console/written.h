#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

// The first line that a verb prints on stdout after it wrote a file.

namespace sightline {

// "812 bytes", "14.2 kB", "1.43 MB", "2.10 GB": decimal units.
std::string size_text(std::uint64_t bytes);

// "Wrote town.slmap (1.43 MB): 601 places, 600 m of route", with its end; without `about` only path
// and size. Empty where the path does not lead to a regular file (/dev/stdout, a pipe), so that
// nothing is added to data that goes there.
std::string written_line(const std::filesystem::path& file, const std::string& about = "");

// Prints that line on stdout, unless quiet.
void print_written(const std::filesystem::path& file, const std::string& about = "");

}  // namespace sightline

#pragma once

#include <filesystem>
#include <string>

namespace sightline {

// A street at Karlsruhe in UTM zone 32 with its compiled map, town.yaml and town.slmap. Made once a
// process, removed at its end.
const std::filesystem::path& compiled_town();
std::string map_file();
std::string config_file();

// `sightline export SOURCE -o OUTPUT OPTIONS`, which must succeed.
void export_to(const std::filesystem::path& output, const std::string& source,
               const std::string& options);

}  // namespace sightline

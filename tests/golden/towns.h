#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/result.h"

namespace sightline::golden {

std::vector<std::string> town_names();

// Writes the recordings of every town to folder/NAME with its configuration, folder/NAME/town.yaml,
// taken from `configs`/NAME.yaml. Replaces earlier ones.
// Errors: those of write_town, and those of reading and writing files.
Result<void> write_towns(const std::filesystem::path& configs, const std::filesystem::path& folder);

}  // namespace sightline::golden

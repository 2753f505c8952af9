#pragma once

#include <filesystem>
#include <string>

namespace sightline {

// ".pcd" of "a/B.PCD".
std::string lower_extension(const std::filesystem::path& path);

}  // namespace sightline

#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace sightline {

// A set of recordings that are not part of the project (tests/README.md lists them).
struct RealData {
  std::filesystem::path folder;  // of the set
  std::string missing;           // why it is not there; empty where it is
};

inline RealData real_data(const std::string& set) {
  const char* data = std::getenv("SIGHTLINE_DATA");
  if (data == nullptr || *data == '\0') {
    return {{}, "SIGHTLINE_DATA names no folder of recordings: without " + set};
  }
  const std::filesystem::path folder = std::filesystem::path(data) / set;
  if (!std::filesystem::is_directory(folder)) {
    return {{}, "SIGHTLINE_DATA has no set " + set};
  }
  return {folder, ""};
}

}  // namespace sightline

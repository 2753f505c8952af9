#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace sightline {

// A folder of this process alone: tests run side by side, on shared machines too.
inline std::filesystem::path scratch_folder() {
  return std::filesystem::path(::testing::TempDir()) / ("sightline_" + std::to_string(::getpid()));
}

}  // namespace sightline

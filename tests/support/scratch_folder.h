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

// A test with an empty folder, which is removed at its end.
class TestInFolder : public ::testing::Test {
 protected:
  TestInFolder() {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~TestInFolder() override { std::filesystem::remove_all(folder_); }

  const std::filesystem::path folder_ = scratch_folder();
};

}  // namespace sightline

#pragma once

#include <filesystem>
#include <string>

namespace sightline {

struct ProgramResult {
  int status = 0;
  std::string out;
  std::string err;
};

// Runs a shell command and waits for it.
ProgramResult run_command(const std::string& command);

// `sightline ARGUMENTS`.
ProgramResult run_sightline(const std::string& arguments);

// A folder with a small generated town and the configuration town.yaml: two ranges, few starts and
// few trees, so that a compile takes seconds. Made once a process, removed at its end.
const std::filesystem::path& small_town();

// A new empty folder, named after the running test.
std::filesystem::path fresh_folder();

}  // namespace sightline

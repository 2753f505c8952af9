#pragma once

#include <filesystem>
#include <string>

namespace sightline {

struct ProgramResult {
  int status = 0;
  std::string out;
  std::string err;
};

ProgramResult run_command(const std::string& command);
ProgramResult run_sightline(const std::string& arguments);
ProgramResult run_successfully(const std::string& arguments);

// A town that the generator makes by these options, with a configuration of its mapping drive and
// the first other one, town.yaml: two ranges, few starts and few trees.
void make_town(const std::filesystem::path& folder, const std::string& options);

// A folder with a small generated town and the configuration town.yaml: two ranges, few starts and
// few trees, so that a compile takes seconds. Made once a process, removed at its end.
const std::filesystem::path& small_town();

// A street at Karlsruhe in UTM zone 32 with its compiled map, town.yaml and town.slmap. Made once a
// process, removed at its end.
const std::filesystem::path& compiled_town();
std::string map_file();
std::string config_file();

// `sightline export SOURCE -o OUTPUT OPTIONS`, which must succeed.
void export_to(const std::filesystem::path& output, const std::string& source,
               const std::string& options);

std::string bytes_of(const std::filesystem::path& path);

// A new empty folder, named after the running test.
std::filesystem::path fresh_folder();

}  // namespace sightline

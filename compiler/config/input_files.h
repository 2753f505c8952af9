#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compiler/config/compile_config.h"

namespace sightline {

// What a compile reads, each once, sorted. A scan that is added to a folder or taken away changes
// the compile too, though no file that it read before.
struct InputFiles {
  std::vector<std::filesystem::path> files;
  std::vector<std::filesystem::path> folders;  // of scans
};

// Of the configuration `file` (empty: there is none) and of the model that is given to it (empty:
// none). Reads no scan
// files but those that hold many scans. Errors: those of list_recording.
Result<InputFiles> input_files(const CompileConfig& config, const std::filesystem::path& file,
                               const std::filesystem::path& model);

// "target: input input ..." as Make and Ninja read it, with blanks, # and $ escaped.
std::string depfile_text(const std::string& target, const InputFiles& inputs);

}  // namespace sightline

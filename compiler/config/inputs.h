#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compiler/config/compile_config.h"

// What a configuration names from outside.

namespace sightline {

// What a compile reads, each once, sorted. A scan that is added to a folder or taken away changes
// the compile too, though no file that it read before.
struct InputFiles {
  std::vector<std::filesystem::path> files;
  std::vector<std::filesystem::path> folders;  // of scans
};

// Of the configuration `file` (empty: there is none) and of the model that is given to it (empty:
// none). Reads no scan files but those that hold many scans. Errors: those of list_recording.
Result<InputFiles> input_files(const CompileConfig& config, const std::filesystem::path& file,
                               const std::filesystem::path& model);

// "target: input input ..." as Make and Ninja read it, with blanks, # and $ escaped.
std::string depfile_text(const std::string& target, const InputFiles& inputs);

// Refuses a recording that is named twice under `mapping` or twice under `localization`, with links
// and slashes of its path resolved (of copies see provide_drives). Where each localization drive is
// a mapping drive, by path or content, the configuration becomes that without `localization`
// (CompileConfig::is_split), and a note says so. Errors: bad-value (named twice; some of several
// localization drives are mapping drives; a split is asked for beside another localization drive).
Result<void> settle_same_recordings(CompileConfig& config);

// Whether the evaluation drive holds the scans of a mapping or localization drive, however either
// is named, placed or timed.
bool is_known_evaluation(const CompileConfig& config);

}  // namespace sightline

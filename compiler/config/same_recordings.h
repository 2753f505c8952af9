#pragma once

#include <filesystem>

#include "compiler/config/compile_config.h"

// Recordings that a configuration names more than once.

namespace sightline {

// Refuses a recording that is named twice under `mapping` or twice under `localization`, with links
// and slashes of its path resolved (of copies see provide_drives). Where each localization drive is
// a mapping drive, by path or content, the configuration becomes that without `localization`
// (CompileConfig::is_split), and a note says so. Errors: bad-value (named twice; some of several
// localization drives are mapping drives; a split is asked for beside another localization drive).
Result<void> settle_same_recordings(const std::filesystem::path& file, CompileConfig& config);

// Adds a note where the evaluation drive made the map or was localized in it, so that it judges
// what it made. The mapping drive of a split is judged by its other scans (evaluate_plan).
void note_known_evaluation(CompileConfig& config);

}  // namespace sightline

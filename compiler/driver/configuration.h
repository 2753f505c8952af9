#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compiler/config/compile_config.h"

namespace sightline {

// Every section of the configuration, of drives and of passes, with its defaults.
std::vector<ConfigSection> published_sections(CompileConfig& config);

// Reads a configuration and overrides ("section.key=value") of it. Errors: those of
// read_compile_config and settle_same_recordings.
Result<CompileConfig> load_compile_config(const std::filesystem::path& file,
                                          const std::vector<std::string>& overrides);

// The same of overrides alone: there is no file.
Result<CompileConfig> compile_config_of(const std::vector<std::string>& overrides);

}  // namespace sightline

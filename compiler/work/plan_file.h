#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

struct PlannedRecording {
  std::string role;    // section of the configuration: "mapping", "localization", ...
  std::string digest;  // hexadecimal
  friend bool operator==(const PlannedRecording&, const PlannedRecording&) = default;
};

// What a plan folder says of the compile that it is for: `plan.json` in it
// (schemas/plan.schema.json). Finished work lies beside it, in `store`.
struct PlanFile {
  std::filesystem::path folder;         // in which `sightline plan` was called: paths begin here
  std::filesystem::path configuration;  // absolute
  std::vector<std::string> overrides;   // "section.key=value"
  std::filesystem::path model;          // absolute; empty: one is trained
  std::string values;                   // digest of every value that the configuration sets
  std::vector<PlannedRecording> recordings;  // as they were then
};

std::filesystem::path plan_file_in(const std::filesystem::path& plan);
std::filesystem::path store_in(const std::filesystem::path& plan);

std::string to_json(const PlanFile& plan);

// Reads plan.json of a plan folder. Errors: file-not-found, too-large, malformed-text (no such
// JSON), future-version, missing-key.
Result<PlanFile> read_plan_file(const std::filesystem::path& plan);

}  // namespace sightline

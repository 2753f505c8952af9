#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/golden/step_outputs.h"

// The text that is kept of one step's output, small enough to be reviewed as a diff; which step
// changed, and why that is wrong or what is left to do.

namespace sightline::golden {

// Golden texts by the name of their file, "town16/build-ndt.txt".
using GoldenFiles = std::map<std::string, std::string>;
GoldenFiles golden_files(const std::vector<RunOutput>& runs);

// Empty where all runs of a town are as their golden files say. Otherwise each step whose output
// changed though its inputs did not, in running order, with the first differing lines; then the
// names of the steps after them, whose own part in it cannot be distinguished; then files of no
// step.
std::string compare(const std::vector<RunOutput>& runs, const GoldenFiles& kept);

// "ingest:localization" -> "ingest.localization.txt".
std::string file_name(const std::string& step);

// Step and version, the digest of the whole artifact, its single facts, and at most 24 of its rows,
// evenly spread, with numbers at 9 significant digits.
std::string golden_text(const StepOutput& output);

// What a golden text says of the whole; empty and 0 where it does not.
struct GoldenHead {
  std::uint32_t version = 0;
  std::string encoding;
  std::string digest;
};
GoldenHead read_head(const std::string& text);

// The first lines in which the texts differ: "- " as kept, "+ " as made now.
std::string first_differences(const std::string& kept, const std::string& made);

}  // namespace sightline::golden

#pragma once

#include <cstdint>
#include <string>

#include "tests/golden/step_outputs.h"

// The text that is kept of one step's output, small enough to be reviewed as a diff.

namespace sightline::golden {

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

#pragma once

#include <filesystem>
#include <vector>

#include "formats/map/delta/delta_format.h"
#include "formats/map/delta/piece_reader.h"

// Follows a delta step by step.

namespace sightline {

struct OpenedDelta {
  PieceReader file;
  DeltaHeader header;
  std::vector<DeltaStep> steps;
};

// Reads and checks all but the payloads, as schemas/delta_format.md demands before a byte is
// written.
Result<OpenedDelta> open_delta(const std::filesystem::path& path);

// The bytes of the result that a step makes of the base, checked; its payload begins at a byte of
// the delta. Memory: a few times kLargestStep.
// Errors: checksum-mismatch, bad-delta, digest-mismatch, truncated-file, cannot-read.
Result<std::vector<std::byte>> make_step(const OpenedDelta& delta, const PieceReader& base,
                                         const DeltaStep& step, std::uint64_t payload_offset);

}  // namespace sightline

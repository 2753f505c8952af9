#pragma once

#include <string>
#include <vector>

#include "formats/artifact.h"
#include "formats/base/hash.h"
#include "formats/drive/identity/scan_sketch.h"
#include "formats/record/fields.h"

namespace sightline {

// A recording that something was made from, so that the owner of recordings can see whether they
// are these.
struct RecordingCard {
  std::string role;  // section of the configuration: "mapping", "mapping-2", "localization", ...
  std::string name;
  Digest digest{};  // Recording::digest; schemas/model_format.md says how it is made
  // Of each scan, in their order; empty: the origin of the recording is not known.
  std::vector<ScanSketch> scans = {};
  friend bool operator==(const RecordingCard&, const RecordingCard&) = default;
};
SIGHTLINE_FIELDS(RecordingCard, role, name, digest, scans)

// All recordings behind the numbers of one place.
struct RecordingCards {
  std::vector<RecordingCard> cards;  // at least one; each role once
  friend bool operator==(const RecordingCards&, const RecordingCards&) = default;
};
SIGHTLINE_FIELDS(RecordingCards, cards)
SIGHTLINE_ARTIFACT(RecordingCards, "recording-cards", 2)

// Error: invalid-artifact, also for a digest of zeros, which is none.
Result<void> validate(const RecordingCards& recordings);
Table dump(const RecordingCards& recordings);

}  // namespace sightline

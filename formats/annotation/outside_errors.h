#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/artifact.h"
#include "formats/drive/localizer_profile.h"
#include "formats/record/fields.h"

namespace sightline {

// How far off a localizer outside of this program ended, once.
struct OutsideError {
  std::uint32_t scan = 0;   // 0-based, in the recording
  double range_m = 0.0;     // how far it looked
  std::uint32_t start = 0;  // 0, 1, ...: where it was started, the same for every scan
  double error_m = 0.0;     // 3D distance from the reference
  std::uint32_t line = 0;   // of the file that names it, from 1
};
SIGHTLINE_FIELDS(OutsideError, scan, range_m, start, error_m, line)

// What a file of import-errors says of one drive.
struct OutsideErrors {
  std::string file;  // its name, without folders
  LocalizerProfile localizer;
  ErrorReference reference = ErrorReference::kKnownPose;
  std::vector<OutsideError> errors;  // ascending (scan, range_m, start), each once
};
SIGHTLINE_FIELDS(OutsideErrors, file, localizer, reference, errors)
SIGHTLINE_ARTIFACT(OutsideErrors, "outside-errors", 1)

// Error: invalid-artifact, at the line.
Result<void> validate(const OutsideErrors& outside);
Table dump(const OutsideErrors& outside);

}  // namespace sightline

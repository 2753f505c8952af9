#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "formats/base/result.h"
#include "formats/record/fields.h"

namespace sightline {

// A contradiction in the inputs of a map that was accepted with a warning.
struct Notice {
  std::string code;              // stable, of a-z and -: "given-poses-disagree"
  std::string text;              // the warning: sentences without a full stop at the end
  std::uint32_t count = 1;       // of places
  std::uint32_t first_scan = 0;  // of the worst place, recording index
  std::uint32_t last_scan = 0;
  double amount = 0.0;  // there, in `unit`; 0: no figure
  std::string unit;     // "m", "s", "deg", "%"; empty: no figure
  friend bool operator==(const Notice&, const Notice&) = default;
};
SIGHTLINE_FIELDS(Notice, code, text, count, first_scan, last_scan, amount, unit)

// Error: invalid-artifact (no code, an amount that is not finite).
inline Result<void> validate(const Notice& notice) {
  if (!notice.code.empty() && std::isfinite(notice.amount)) return {};
  return Error{ErrorCode::kInvalidArtifact, "a notice has no code, or its amount is not finite"};
}

}  // namespace sightline

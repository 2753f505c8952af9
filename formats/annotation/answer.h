#pragma once

#include <cstdint>

#include "formats/record/fields.h"

namespace sightline {

// The rule that decided a site's look for a limit: the last that applied, in the order of
// passes/model/choice/choices.cpp (schemas/definitions.md, "Why a site has its range"). The map
// stores the number, so numbers are never reused.
enum class Reason : std::uint8_t {
  kNone,             // of the vehicle's reader: no answer of a site was used
  kModel,            // the cheapest that is good enough by the model
  kMostProbable,     // none is: the most probable; by mean the longest
  kExtrapolated,     // the place is unlike those of the training: the static answer
  kDilation,         // a neighbour on the route needs it
  kSimulation,       // by what was simulated at this site
  kNoDrive,          // no drive was here: the static answer by what was simulated
  kTooShort,         // the drive is too short to learn from: the static answer
  kExplainsNothing,  // so does the model: the static answer
  kCheaper,          // the static answer costs less than the model's and covers as much
  kDrives,           // the drives, each left out in turn, prefer one static answer
  kTighterLimit      // the next tighter limit needs no more
};
template <>
inline constexpr auto kNamesOf<Reason> = enum_names("none", "model", "most-probable",
                                                    "extrapolated", "dilation", "simulation",
                                                    "no-drive", "too-short", "explains-nothing",
                                                    "cheaper", "drives", "tighter-limit");

}  // namespace sightline

#pragma once

#include <string>

#include "passes/localize/tune_ndt.h"

// What `sightline tune` found, for people and for programs.

namespace sightline {

// What was done, a table of three rows, and what to set, or that nothing helps.
std::string to_text(const NdtTuning& tuning);

// As schemas/tune.schema.json describes it.
std::string to_json(const NdtTuning& tuning);

}  // namespace sightline

#pragma once

#include "formats/drive/drive.h"
#include "passes/pass/pass.h"

namespace sightline {

// The option "scans" of several passes, which the plan sets: which scans of the recording they use.
inline OptionField scans_option(ScanSelection& value) {
  return shared(choice("scans", value, "scans to use, by 0-based index in the recording",
                       {"all", "even", "odd"}));
}

}  // namespace sightline

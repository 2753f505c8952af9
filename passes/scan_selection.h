#pragma once

#include <string>
#include <string_view>

#include "compiler/pipeline/options.h"
#include "formats/drive.h"

namespace sightline {

// The option "scans" that several passes share: which scans of the recording they use.
inline OptionField scans_option(std::string& value) {
  return choice("scans", value, "scans to use, by 0-based index in the recording",
                {"all", "even", "odd"});
}

// The selection that a value of that option names.
inline ScanSelection scan_selection(std::string_view value) {
  if (value == "even") return ScanSelection::kEven;
  if (value == "odd") return ScanSelection::kOdd;
  return ScanSelection::kAll;
}

}  // namespace sightline

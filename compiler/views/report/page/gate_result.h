#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// What `sightline gate --json` wrote, as far as the page shows it.
struct GateResult {
  struct Violation {
    std::string rule;
    std::string severity;  // "note", "warning", "error"
    std::string message;
    std::optional<std::uint32_t> first_site;  // where it has a place in this map
  };
  std::string root_digest;  // of the map that was judged, hexadecimal
  bool passed = false;
  std::uint32_t errors = 0;
  std::uint32_t warnings = 0;
  std::uint32_t notes = 0;
  std::uint32_t excepted = 0;
  std::vector<Violation> violations;
};

// Errors: malformed-text where it is not what `gate --json` writes; those of reading a file.
Result<GateResult> read_gate_result(const std::filesystem::path& file);

}  // namespace sightline

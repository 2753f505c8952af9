#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "formats/base/result.h"

// A copy of a map whose blocks stay packed as they are, so that no digest but those of what is left
// out changes, and no signature either.

namespace sightline {

struct Repacked {
  std::vector<std::byte> file;
  std::vector<std::string> actions;  // what was done, a sentence each
};

// The map without what only engineers need: the layers "factors" and "debug", the sections
// "factor-names" and "error-model". What is optional and unknown stays. The map is checked as a
// whole first: damage is not copied. `file` starts at a multiple of 8. Errors: those of
// verify_map().
Result<Repacked> strip_map(std::span<const std::byte> file);

}  // namespace sightline

#pragma once

#include <cstddef>
#include <vector>

#include "compiler/gate/rules/rules.h"

// What rules over two maps share.

namespace sightline {

// A limit that both maps have, and which of theirs it is.
struct SharedLimit {
  double limit_m = 0.0;
  std::size_t in_new = 0;
  std::size_t in_old = 0;
};

std::vector<SharedLimit> shared_limits(const GateInput& input);

}  // namespace sightline

#pragma once

#include <string>
#include <vector>

#include "compiler/gate/rules/finding.h"
#include "compiler/gate/settings.h"
#include "formats/map/compiled_map.h"

namespace sightline {

// Turns violations that a valid exception covers into excepted checks, and appends what the
// exceptions themselves give rise to. `old_map` may be nullptr.
void apply_exceptions(const GateSettings& settings, const CompiledMap& map,
                      const CompiledMap* old_map, GateReport& report);

}  // namespace sightline

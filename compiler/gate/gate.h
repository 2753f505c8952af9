#pragma once

#include <string>

#include "compiler/gate/rules/rules.h"
#include "compiler/gate/settings.h"
#include "formats/base/result.h"
#include "formats/map/compiled_map.h"
#include "formats/map/map_reader.h"

namespace sightline {

// A map and the file that it was read from.
struct GateMap {
  std::string file;  // as findings name it
  const CompiledMap& map;
  const MapSummary& summary;
};

struct GateSubject {
  const GateMap& map;
  const GateMap* old_map = nullptr;          // nullptr: rules over two maps are left out
  const Observation* observation = nullptr;  // nullptr: rules of an observing drive are left out
  const EvaluationFigures* evaluation = nullptr;  // of the same drive, for the verdict
};

// Judges by every rule that is on. A finding is excepted where an exception names its rule and
// limit, is not past its end on `today` (YYYY-MM-DD), and covers every site of the finding's place;
// findings without a place are covered by exceptions without one alone. Expired and unused
// exceptions are findings of their own. Errors: mismatched-inputs (the observation is of another
// map), bad-argument (no such day).
Result<GateReport> judge(const GateSubject& subject, const GateSettings& settings,
                         const std::string& today);

}  // namespace sightline

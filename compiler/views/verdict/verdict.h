#pragma once

#include <string_view>

#include "compiler/views/verdict/map_judgement.h"
#include "formats/map/compiled_map.h"

// One verdict on a map, the same in every verb, page and comment (schemas/gate_rules.md,
// "Verdict").

namespace sightline {

std::string_view word_of(MapVerdict verdict);    // "good", "partly", "bad", "not judged"
std::string_view colour_of(MapVerdict verdict);  // "green", "yellow", "red", "grey"

// A pure function of the map, which may lack NDs and factors, and of an evaluation of it (null:
// none). An evaluation that was simulated counts as none.
MapJudgement judge_map(const CompiledMap& map, const EvaluationFigures* evaluation,
                       const VerdictFiles& files);

}  // namespace sightline

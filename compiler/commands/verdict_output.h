#pragma once

#include <optional>
#include <string>

#include "compiler/views/verdict/verdict.h"

namespace sightline {

// The text, which begins with the verdict's head, with that in its colour (toned()): for
// print_text().
std::string with_toned_verdict(const MapJudgement& judgement, const std::string& text);

// The figures of an evaluation file; none where no file is named.
Result<std::optional<EvaluationFigures>> figures_in(const std::string& file,
                                                    const CompiledMap& map);

}  // namespace sightline

#pragma once

#include <string>

#include "compiler/views/verdict/verdict.h"

namespace sightline {

// Prints the verdict, the promise and the next command on stdout, the verdict's word in its colour
// where stdout is a terminal.
void print_verdict(const MapJudgement& judgement);
// The same without the promise.
void print_short_verdict(const MapJudgement& judgement);

// Prints a text that begins with the verdict's head.
void print_behind_verdict(const MapJudgement& judgement, const std::string& text);

// The figures of an evaluation file; none where no file is named.
Result<std::optional<EvaluationFigures>> figures_in(const std::string& file,
                                                    const CompiledMap& map);

}  // namespace sightline

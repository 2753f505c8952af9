#include "compiler/commands/verdict_output.h"

#include "compiler/cli/console/console.h"
#include "compiler/views/verdict/verdict_text.h"

namespace sightline {
namespace {

Tone tone_of(MapVerdict verdict) {
  static constexpr Tone kTones[] = {Tone::kGood, Tone::kWarning, Tone::kBad, Tone::kFaint};
  return kTones[static_cast<std::size_t>(verdict)];
}

}  // namespace

std::string with_toned_verdict(const MapJudgement& judgement, const std::string& text) {
  const std::string head = verdict_head(judgement);
  return toned(tone_of(judgement.verdict), head) + text.substr(head.size());
}

Result<std::optional<EvaluationFigures>> figures_in(const std::string& file,
                                                    const CompiledMap& map) {
  if (file.empty()) return std::optional<EvaluationFigures>();
  SIGHTLINE_ASSIGN(EvaluationFigures figures, read_evaluation(file, map));
  return std::optional(std::move(figures));
}

}  // namespace sightline

#include "compiler/commands/verdict_output.h"

#include "compiler/cli/console/console.h"
#include "compiler/views/verdict/verdict_text.h"

namespace sightline {
namespace {

TextColour terminal_colour(MapVerdict verdict) {
  static constexpr TextColour kColours[] = {TextColour::kGreen, TextColour::kYellow,
                                            TextColour::kRed, TextColour::kGrey};
  return kColours[static_cast<std::size_t>(verdict)];
}

}  // namespace

void print_behind_verdict(const MapJudgement& judgement, const std::string& text) {
  const std::string head = verdict_head(judgement);
  print_coloured(terminal_colour(judgement.verdict), head);
  print_text(std::string_view(text).substr(head.size()));
}

void print_verdict(const MapJudgement& judgement) {
  print_behind_verdict(judgement, to_text(judgement));
}

void print_short_verdict(const MapJudgement& judgement) {
  MapJudgement without_promise = judgement;
  without_promise.promise.clear();
  print_verdict(without_promise);
}

Result<std::optional<EvaluationFigures>> figures_in(const std::string& file,
                                                    const CompiledMap& map) {
  if (file.empty()) return std::optional<EvaluationFigures>();
  SIGHTLINE_ASSIGN(EvaluationFigures figures, read_evaluation(file, map));
  return std::optional(std::move(figures));
}

}  // namespace sightline

#pragma once

#include <cstddef>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/annotation/predicted_error.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"
#include "formats/evaluation/evaluation.h"
#include "formats/model/place_kind.h"
#include "passes/model/promise/selection.h"

// Figures of evaluate-ranges, each worked out from what was measured.

namespace sightline {

// What all scores are worked out from.
struct EvaluationInputs {
  double stretch_m = 0.0;  // of route, of the worst stretch
  const Sites& sites;
  const PredictedError& predicted;
  const RangeTable& ranges;
  const MeasuredError& judged;
  std::vector<PlaceKind> kinds;           // [site]
  std::vector<std::size_t> judged_sites;  // that have a scan

  [[nodiscard]] std::size_t longest() const { return ranges.looks.size() - 1; }
  [[nodiscard]] double limit_m(std::size_t limit) const { return predicted.limits_m[limit]; }
};

// One rule's choice over all judged sites, and where along the route it fares worst.
RuleScore score_choice(const EvaluationInputs& inputs, double limit_m, Rule rule,
                       const Choice& choice);

// The same by kind of place.
void append_kind_scores(const EvaluationInputs& inputs, double limit_m, Rule rule,
                        const Choice& choice, std::vector<KindScore>& kinds);

// One range everywhere, by its index.
StaticScore score_static(const EvaluationInputs& inputs, std::size_t range);

// Does what was promised 80 % of the time happen 80 % of the time?
void append_reliability(const EvaluationInputs& inputs, std::size_t limit,
                        std::vector<ReliabilityBin>& reliability);

}  // namespace sightline

#include "formats/annotation/equal_coverage.h"

#include "formats/base/check.h"

namespace sightline {
namespace {

// Of equal cost the one that covers more.
bool is_cheaper(const CoveredCost& a, const CoveredCost& b) {
  return a.cost < b.cost || (a.cost == b.cost && a.coverage > b.coverage);
}

// Of equal coverage the cheaper one.
bool covers_more(const CoveredCost& a, const CoveredCost& b) {
  return a.coverage > b.coverage || (a.coverage == b.coverage && a.cost < b.cost);
}

}  // namespace

CostAtCoverage cost_at_coverage(std::span<const CoveredCost> answers, double coverage) {
  SIGHTLINE_CHECK(!answers.empty());
  const CoveredCost* above = nullptr;  // the cheapest that covers enough
  const CoveredCost* most = &answers.front();
  for (const CoveredCost& answer : answers) {
    if (answer.coverage >= coverage && (above == nullptr || is_cheaper(answer, *above))) {
      above = &answer;
    }
    if (covers_more(answer, *most)) most = &answer;
  }
  if (above == nullptr) return {most->coverage, most->cost, false};
  // Its neighbour: of those that cost less, none of which covers enough, the one that covers most.
  const CoveredCost* below = nullptr;
  for (const CoveredCost& answer : answers) {
    if (!(answer.cost < above->cost)) continue;
    if (below == nullptr || covers_more(answer, *below)) below = &answer;
  }
  if (below == nullptr) return {coverage, above->cost, true};
  const double share = (coverage - below->coverage) / (above->coverage - below->coverage);
  return {coverage, below->cost + share * (above->cost - below->cost), true};
}

}  // namespace sightline

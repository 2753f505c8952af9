#include "formats/evaluation/look_evaluation.h"

#include <algorithm>
#include <cmath>

#include "formats/base/check.h"
#include "formats/record/cells.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

bool is_share(double value) { return value >= 0.0 && value <= 1.0; }
bool is_amount(double value) { return std::isfinite(value) && value >= 0.0; }

std::string limit_text(double limit_m) { return fixed(100.0 * limit_m, 0) + " cm"; }

// Coverage and time of a rule, and how the map's time compares: no rule is called faster that takes
// longer.
std::string compared(const LookRuleScore& map, const LookRuleScore& other) {
  const std::string at =
      percent(other.coverage) + " in " + fixed(other.time_ratio, 3) + " of the time";
  constexpr double kRounding = 1e-9;
  if (other.coverage < map.coverage - kRounding) return at + " (no such look covers more)";
  const double saved = other.time_ratio > 0.0 ? 1.0 - map.time_ratio / other.time_ratio : 0.0;
  constexpr double kAlike = 0.005;
  if (std::abs(saved) < kAlike) return at + " (the map's look takes the same time)";
  if (saved > 0.0) return at + " (the map's look takes " + fixed(100.0 * saved, 0) + " % less)";
  // Times scatter, work does not: what is dearer in the one alone is not called so.
  if (map.work_ratio <= other.work_ratio) return at + " (the map's look takes the same time)";
  return at + " (the map's look takes " +
         fixed(100.0 * (map.time_ratio / other.time_ratio - 1.0), 0) + " % MORE)";
}

std::string sentence(const LookEvaluation& evaluation, std::size_t limit) {
  const LookRuleScore& map = evaluation.score(limit, LookRule::kMap);
  return "Within " + limit_text(map.limit_m) + ": the map's look covers " + percent(map.coverage) +
         " in " + fixed(map.time_ratio, 3) +
         " of the time. The best constant look with the map's normals covers " +
         compared(map, evaluation.score(limit, LookRule::kSameEverywhere)) +
         (evaluation.has_baselines
              ? "; without a map, " +
                    compared(map, evaluation.score(limit, LookRule::kSameWithoutMap))
              : "; looks that need no map were not measured, run evaluate to compare them") +
         ".\n";
}

bool is_told(const LookEvaluation& evaluation, const LookRuleScore& score) {
  return evaluation.has_baselines || score.rule != LookRule::kSameWithoutMap;
}

std::string rules_text(const LookEvaluation& evaluation) {
  TextGrid grid = {{"limit", "rule", "coverage %", "time ratio", "work ratio", "answered %",
                    "missed of answered %", "unmet %", "of these truly %"}};
  for (const LookRuleScore& score : evaluation.rules) {
    if (!is_told(evaluation, score)) continue;
    grid.push_back({limit_text(score.limit_m), std::string(name_of(score.rule)),
                    in_percent(score.coverage), fixed(score.time_ratio, 3),
                    fixed(score.work_ratio, 3), in_percent(1.0 - score.unmet_share),
                    in_percent(score.answered_miss_share), in_percent(score.unmet_share),
                    score.unmet_share > 0.0 ? in_percent(score.truly_unmet_share) : "-"});
  }
  return aligned(grid);
}

std::string statics_text(const LookEvaluation& evaluation) {
  TextGrid grid = {{"one look everywhere"}};
  for (const double limit_m : evaluation.limits_m) {
    grid.front().push_back("within " + limit_text(limit_m) + " %");
  }
  for (const char* name : {"error cm", "time ratio", "work ratio"}) grid.front().emplace_back(name);
  for (const StaticLook& look : evaluation.statics) {
    std::vector<std::string>& row = grid.emplace_back();
    row.push_back(to_text(look.look));
    for (const double coverage : look.coverage) row.push_back(in_percent(coverage));
    row.push_back(fixed(100.0 * look.mean_error_m, 1));
    row.push_back(fixed(look.time_ratio, 3));
    row.push_back(fixed(look.work_ratio, 3));
  }
  return aligned(grid);
}

// Of equal cost the one that covers more.
bool is_cheaper(const CoveredCost& a, const CoveredCost& b) {
  return a.cost < b.cost || (a.cost == b.cost && a.coverage > b.coverage);
}

// Of equal coverage the cheaper one.
bool covers_more(const CoveredCost& a, const CoveredCost& b) {
  return a.coverage > b.coverage || (a.coverage == b.coverage && a.cost < b.cost);
}

}  // namespace

Result<void> validate(const LookEvaluation& evaluation) {
  const auto invalid = [](const std::string& message) {
    return Error{ErrorCode::kInvalidArtifact, message, "", "looks"};
  };
  if (evaluation.limits_m.empty() || evaluation.statics.empty() ||
      evaluation.rules.size() != evaluation.limits_m.size() * kLookRuleCount) {
    return invalid("an evaluation of looks needs limits, looks and all rules");
  }
  for (const StaticLook& look : evaluation.statics) {
    SIGHTLINE_TRY(validate(look.look));
    if (look.coverage.size() != evaluation.limits_m.size() ||
        !std::ranges::all_of(look.coverage, is_share) || !is_amount(look.mean_error_m) ||
        !is_amount(look.time_ratio) || !is_amount(look.work_ratio)) {
      return invalid("the score of '" + to_text(look.look) + "' is out of range");
    }
  }
  for (std::size_t i = 0; i < evaluation.rules.size(); ++i) {
    const LookRuleScore& score = evaluation.rules[i];
    if (static_cast<std::size_t>(score.rule) != i % kLookRuleCount ||
        score.limit_m != evaluation.limits_m[i / kLookRuleCount] || !is_share(score.coverage) ||
        !is_share(score.unmet_share) || !is_share(score.answered_miss_share) ||
        !is_share(score.truly_unmet_share) || !is_amount(score.time_ratio) ||
        !is_amount(score.work_ratio)) {
      return invalid("a score is out of order or out of range");
    }
  }
  return {};
}

std::vector<Table> tables(const LookEvaluation& evaluation) {
  Table rules{"evaluation-looks", {}, {}, {}};
  append_columns<LookRuleScore>(rules.columns);
  for (const LookRuleScore& score : evaluation.rules) {
    if (is_told(evaluation, score)) append_cells(score, rules.rows.emplace_back());
  }
  Table statics{"evaluation-static-looks",
                {"look", "limit_m", "coverage", "mean_error_m", "time_ratio", "work_ratio"},
                {},
                {}};
  for (const StaticLook& look : evaluation.statics) {
    for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
      statics.rows.push_back({to_text(look.look), evaluation.limits_m[limit], look.coverage[limit],
                              look.mean_error_m, look.time_ratio, look.work_ratio});
    }
  }
  return {rules, statics};
}

std::string to_text(const LookEvaluation& evaluation) {
  std::string text = "Looks (ratios to the longest range with every return)\n";
  text += rules_text(evaluation);
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    text += sentence(evaluation, limit);
  }
  return text + "\n" + statics_text(evaluation);
}

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

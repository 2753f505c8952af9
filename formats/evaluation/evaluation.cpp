#include "formats/evaluation/evaluation.h"

#include <algorithm>
#include <cmath>

#include "formats/record/fields.h"

namespace sightline {
namespace {

Result<void> validate_shape(const Evaluation& evaluation) {
  const std::size_t pairs = evaluation.sites.size() * evaluation.statics.size();
  const std::size_t rule_count = evaluation.limits_m.size() * kRuleCount;
  if (evaluation.sites.empty() || evaluation.statics.empty() || evaluation.limits_m.empty()) {
    return invalid_artifact("an evaluation needs judged sites, ranges and limits", "");
  }
  if (evaluation.rules.size() != rule_count || evaluation.error_m.size() != pairs ||
      evaluation.time_ms.size() != pairs ||
      evaluation.chosen_range_index.size() != rule_count * evaluation.sites.size()) {
    return invalid_artifact("scores or choices do not fill the judged sites, ranges and limits",
                            "");
  }
  if (evaluation.out_of_fold_count > evaluation.sites.size() ||
      !std::isfinite(evaluation.stretch_m)) {
    return invalid_artifact("counts or the length of the worst stretch make no sense", "");
  }
  return {};
}

Result<void> validate_rules(const Evaluation& evaluation) {
  for (std::size_t i = 0; i < evaluation.rules.size(); ++i) {
    const RuleScore& score = evaluation.rules[i];
    const bool is_in_place = static_cast<std::size_t>(score.rule) == i % kRuleCount &&
                             score.limit_m == evaluation.limits_m[i / kRuleCount];
    const double shares[] = {score.coverage, score.unmet_share, score.extrapolated_share,
                             score.worst_coverage};
    const bool are_shares = std::all_of(std::begin(shares), std::end(shares),
                                        [](double share) { return share >= 0.0 && share <= 1.0; });
    if (!is_in_place || !are_shares || !are_finite(score) ||
        score.worst_begin_site > score.worst_end_site ||
        score.worst_end_site >= evaluation.site_count) {
      return invalid_artifact("a score is out of place or makes no sense",
                              "rule " + std::to_string(i));
    }
  }
  return {};
}

Result<void> validate_sites(const Evaluation& evaluation) {
  for (std::size_t i = 0; i < evaluation.sites.size(); ++i) {
    const JudgedSite& site = evaluation.sites[i];
    const bool follows = i == 0 || evaluation.sites[i - 1].site < site.site;
    if (!follows || site.site >= evaluation.site_count || !are_finite(site)) {
      return invalid_artifact("a judged site is out of order or place",
                              "site " + std::to_string(i));
    }
  }
  for (const std::uint8_t index : evaluation.chosen_range_index) {
    if (index >= evaluation.statics.size()) {
      return invalid_artifact("a chosen range is not there", "");
    }
  }
  return {};
}

Result<void> validate_streets(const Evaluation& evaluation) {
  for (std::size_t i = 0; i < evaluation.streets.size(); ++i) {
    const StreetScore& score = evaluation.streets[i];
    const bool is_known = score.street != StreetType::kUnknown;
    const bool are_shares = score.coverage >= 0.0 && score.coverage <= 1.0 &&
                            score.site_share > 0.0 && score.site_share <= 1.0;
    if (!is_known || !are_shares || score.site_count == 0 ||
        score.site_count > evaluation.sites.size() || !are_finite(score)) {
      return invalid_artifact("the score of a type of street makes no sense",
                              "row " + std::to_string(i));
    }
  }
  return {};
}

}  // namespace

Result<void> validate(const Evaluation& evaluation) {
  Result<void> valid = validate_shape(evaluation);
  if (valid) valid = validate_rules(evaluation);
  if (valid) valid = validate_sites(evaluation);
  if (valid) valid = validate_streets(evaluation);
  if (!valid) return valid;
  if (!are_finite(evaluation.statics)) return invalid_artifact("a static score is not finite", "");
  if (!are_finite(evaluation.reliability)) {
    return invalid_artifact("a reliability bin is not finite", "");
  }
  if (evaluation.of_samples.size() > 1) {
    return invalid_artifact("looks are judged more than once", "");
  }
  for (const LookEvaluation& looks : evaluation.of_samples) SIGHTLINE_TRY(validate(looks));
  return {};
}

}  // namespace sightline

#include "formats/evaluation/evaluation.h"

#include <algorithm>
#include <cmath>

#include "formats/record/cells.h"
#include "formats/record/fields.h"

namespace sightline {
namespace {

Result<void> validate_shape(const Evaluation& evaluation) {
  const std::size_t pairs = evaluation.sites.size() * evaluation.statics.size();
  const std::size_t rule_count = evaluation.limits_m.size() * kRuleCount;
  if (evaluation.sites.empty() || evaluation.statics.empty() || evaluation.limits_m.empty()) {
    return invalid_artifact("an evaluation needs evaluated sites, ranges and limits", "");
  }
  if (evaluation.rules.size() != rule_count || evaluation.error_m.size() != pairs ||
      evaluation.time_ms.size() != pairs ||
      evaluation.chosen_range_index.size() != rule_count * evaluation.sites.size()) {
    return invalid_artifact(
        "scores or choices do not match the number of evaluated sites, ranges and limits", "");
  }
  if (evaluation.out_of_fold_count > evaluation.sites.size() ||
      !std::isfinite(evaluation.stretch_m)) {
    return invalid_artifact("counts or the length of the worst stretch are out of range", "");
  }
  return {};
}

Result<void> validate_rules(const Evaluation& evaluation) {
  for (std::size_t i = 0; i < evaluation.rules.size(); ++i) {
    const RuleScore& score = evaluation.rules[i];
    const bool is_in_place = static_cast<std::size_t>(score.rule) == i % kRuleCount &&
                             score.limit_m == evaluation.limits_m[i / kRuleCount];
    const double shares[] = {
        score.coverage,       score.unmet_share,         score.extrapolated_share,
        score.worst_coverage, score.answered_miss_share, score.truly_unmet_share};
    const bool are_shares = std::all_of(std::begin(shares), std::end(shares),
                                        [](double share) { return share >= 0.0 && share <= 1.0; });
    if (!is_in_place || !are_shares || !are_finite(score) ||
        score.worst_begin_site > score.worst_end_site ||
        score.worst_end_site >= evaluation.site_count) {
      return invalid_artifact("a score is out of order or out of range", concat("rule ", i));
    }
  }
  return {};
}

Result<void> validate_sites(const Evaluation& evaluation) {
  for (std::size_t i = 0; i < evaluation.sites.size(); ++i) {
    const JudgedSite& site = evaluation.sites[i];
    const bool follows = i == 0 || evaluation.sites[i - 1].site < site.site;
    if (!follows || site.site >= evaluation.site_count || !are_finite(site)) {
      return invalid_artifact("an evaluated site is out of order", concat("site ", i));
    }
  }
  for (const std::uint8_t index : evaluation.chosen_range_index) {
    if (index >= evaluation.statics.size()) {
      return invalid_artifact("a chosen range does not exist", "");
    }
  }
  return {};
}

Result<void> validate_kinds(const Evaluation& evaluation) {
  for (std::size_t i = 0; i < evaluation.kinds.size(); ++i) {
    const KindScore& score = evaluation.kinds[i];
    const bool is_known = score.kind != PlaceKind::kUnknown;
    const bool are_shares = score.coverage >= 0.0 && score.coverage <= 1.0 &&
                            score.site_share > 0.0 && score.site_share <= 1.0;
    if (!is_known || !are_shares || score.site_count == 0 ||
        score.site_count > evaluation.sites.size() || !are_finite(score)) {
      return invalid_artifact("the score of a kind of place is out of range", concat("row ", i));
    }
  }
  return {};
}

// Site, run and place of a judged site, without its kind of place.
std::vector<std::string> place_columns() {
  std::vector<std::string> columns;
  append_columns<JudgedSite>(columns);
  columns.pop_back();
  return columns;
}

std::vector<Cell> place_cells(const JudgedSite& site) {
  std::vector<Cell> cells;
  append_cells(site, cells);
  cells.pop_back();
  return cells;
}

Table sites_table(const Evaluation& evaluation) {
  Table table;
  table.name = "evaluation-sites";
  append_columns<JudgedSite>(table.columns);
  for (const char* column : {"limit_m", "rule", "range_m", "error_m", "time_ms"}) {
    table.columns.emplace_back(column);
  }
  for (std::size_t i = 0; i < evaluation.sites.size(); ++i) {
    for (std::size_t row = 0; row < evaluation.rules.size(); ++row) {
      const std::size_t range = evaluation.chosen_range_index[row * evaluation.sites.size() + i];
      const std::size_t pair = i * evaluation.statics.size() + range;
      std::vector<Cell>& cells = table.rows.emplace_back();
      append_cells(evaluation.sites[i], cells);
      cells.emplace_back(evaluation.rules[row].limit_m);
      cells.push_back(cell_of(evaluation.rules[row].rule));
      cells.emplace_back(evaluation.statics[range].range_m);
      cells.emplace_back(evaluation.error_m[pair]);
      cells.emplace_back(evaluation.time_ms[pair]);
    }
  }
  return table;
}

// Figures 5 and 6 of the paper.
Table errors_table(const Evaluation& evaluation) {
  Table table;
  table.name = "evaluation-errors";
  table.columns = place_columns();
  for (const char* column : {"range_m", "error_m", "time_ms"}) table.columns.emplace_back(column);
  for (std::size_t pair = 0; pair < evaluation.error_m.size(); ++pair) {
    std::vector<Cell>& cells =
        table.rows.emplace_back(place_cells(evaluation.sites[pair / evaluation.statics.size()]));
    cells.emplace_back(evaluation.statics[pair % evaluation.statics.size()].range_m);
    cells.emplace_back(evaluation.error_m[pair]);
    cells.emplace_back(evaluation.time_ms[pair]);
  }
  return table;
}

}  // namespace

Result<void> validate(const Evaluation& evaluation) {
  Result<void> valid = validate_shape(evaluation);
  if (valid) valid = validate_rules(evaluation);
  if (valid) valid = validate_sites(evaluation);
  if (valid) valid = validate_kinds(evaluation);
  if (!valid) return valid;
  if (!are_finite(evaluation.statics)) return invalid_artifact("a static score is not finite", "");
  if (!are_finite(evaluation.reliability)) {
    return invalid_artifact("a reliability bin is not finite", "");
  }
  return evaluation.samples ? validate(*evaluation.samples) : Result<void>();
}

Table dump(const Evaluation& evaluation) {
  Table table = table_of("evaluation", evaluation.rules);
  table.facts = {{"drive", evaluation.drive},
                 {"reference", cell_of(evaluation.reference)},
                 {"site_count", std::int64_t{evaluation.site_count}},
                 {"judged_count", static_cast<std::int64_t>(evaluation.sites.size())},
                 {"out_of_fold_count", std::int64_t{evaluation.out_of_fold_count}},
                 {"stretch_m", evaluation.stretch_m}};
  return table;
}

std::vector<Table> tables(const Evaluation& evaluation) {
  std::vector<Table> all = {dump(evaluation),
                            table_of("evaluation-static-ranges", evaluation.statics),
                            table_of("evaluation-kinds", evaluation.kinds),
                            table_of("evaluation-reliability", evaluation.reliability),
                            errors_table(evaluation),
                            sites_table(evaluation)};
  if (evaluation.samples) {
    for (Table& table : tables(*evaluation.samples)) all.push_back(std::move(table));
  }
  return all;
}

}  // namespace sightline

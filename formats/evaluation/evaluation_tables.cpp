#include "formats/evaluation/evaluation.h"
#include "formats/evaluation/evaluation_fields.h"

namespace sightline {
namespace {

Table statics_table(const Evaluation& evaluation) {
  Table table;
  table.name = "evaluation-static-ranges";
  append_names(kStaticFields, table.columns);
  for (const StaticScore& score : evaluation.statics) {
    append_cells(kStaticFields, score, table.rows.emplace_back());
  }
  return table;
}

Table streets_table(const Evaluation& evaluation) {
  Table table;
  table.name = "evaluation-street-types";
  table.columns = {"rule", "street", "site_count"};
  append_names(kStreetFields, table.columns);
  for (const StreetScore& score : evaluation.streets) {
    std::vector<Cell>& cells = table.rows.emplace_back();
    cells = {std::string(rule_name(score.rule)), std::string(street_type_name(score.street)),
             std::int64_t{score.site_count}};
    append_cells(kStreetFields, score, cells);
  }
  return table;
}

Table reliability_table(const Evaluation& evaluation) {
  Table table;
  table.name = "evaluation-reliability";
  append_names(kBinFields, table.columns);
  table.columns.emplace_back("count");
  for (const ReliabilityBin& bin : evaluation.reliability) {
    std::vector<Cell>& cells = table.rows.emplace_back();
    append_cells(kBinFields, bin, cells);
    cells.emplace_back(std::int64_t{bin.count});
  }
  return table;
}

Table sites_table(const Evaluation& evaluation) {
  Table table;
  table.name = "evaluation-sites";
  table.columns = {"site", "run"};
  append_names(kSiteFields, table.columns);
  for (const char* column : {"street", "limit_m", "rule", "range_m", "error_m", "time_ms"}) {
    table.columns.emplace_back(column);
  }
  for (std::size_t i = 0; i < evaluation.sites.size(); ++i) {
    for (std::size_t row = 0; row < evaluation.rules.size(); ++row) {
      const std::size_t range = evaluation.chosen_range_index[row * evaluation.sites.size() + i];
      const std::size_t pair = i * evaluation.statics.size() + range;
      std::vector<Cell>& cells = table.rows.emplace_back();
      cells = {std::int64_t{evaluation.sites[i].site}, std::int64_t{evaluation.sites[i].run}};
      append_cells(kSiteFields, evaluation.sites[i], cells);
      cells.emplace_back(std::string(street_type_name(evaluation.sites[i].street)));
      cells.emplace_back(evaluation.rules[row].limit_m);
      cells.emplace_back(std::string(rule_name(evaluation.rules[row].rule)));
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
  table.columns = {"site", "run"};
  append_names(kSiteFields, table.columns);
  for (const char* column : {"range_m", "error_m", "time_ms"}) table.columns.emplace_back(column);
  for (std::size_t pair = 0; pair < evaluation.error_m.size(); ++pair) {
    const JudgedSite& site = evaluation.sites[pair / evaluation.statics.size()];
    std::vector<Cell>& cells = table.rows.emplace_back();
    cells = {std::int64_t{site.site}, std::int64_t{site.run}};
    append_cells(kSiteFields, site, cells);
    cells.emplace_back(evaluation.statics[pair % evaluation.statics.size()].range_m);
    cells.emplace_back(evaluation.error_m[pair]);
    cells.emplace_back(evaluation.time_ms[pair]);
  }
  return table;
}

}  // namespace

Table dump(const Evaluation& evaluation) {
  Table table;
  table.name = "evaluation";
  table.facts = {{"drive", evaluation.drive},
                 {"reference", std::string(reference_name(evaluation.reference))},
                 {"site_count", std::int64_t{evaluation.site_count}},
                 {"judged_count", static_cast<std::int64_t>(evaluation.sites.size())},
                 {"out_of_fold_count", std::int64_t{evaluation.out_of_fold_count}},
                 {"stretch_m", evaluation.stretch_m}};
  table.columns = {"rule"};
  append_names(kRuleFields, table.columns);
  table.columns.emplace_back("worst_begin_site");
  table.columns.emplace_back("worst_end_site");
  for (const RuleScore& score : evaluation.rules) {
    std::vector<Cell>& cells = table.rows.emplace_back();
    cells.emplace_back(std::string(rule_name(score.rule)));
    append_cells(kRuleFields, score, cells);
    cells.emplace_back(std::int64_t{score.worst_begin_site});
    cells.emplace_back(std::int64_t{score.worst_end_site});
  }
  return table;
}

std::vector<Table> tables(const Evaluation& evaluation) {
  std::vector<Table> all = {dump(evaluation),          statics_table(evaluation),
                            streets_table(evaluation), reliability_table(evaluation),
                            errors_table(evaluation),  sites_table(evaluation)};
  for (const LookEvaluation& looks : evaluation.of_samples) {
    for (Table& table : tables(looks)) all.push_back(std::move(table));
  }
  return all;
}

}  // namespace sightline

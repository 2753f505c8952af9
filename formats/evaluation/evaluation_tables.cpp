#include "formats/evaluation/evaluation.h"
#include "formats/record/cells.h"

namespace sightline {
namespace {

// Site, run and place of a judged site, without its type of street.
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
                            table_of("evaluation-street-types", evaluation.streets),
                            table_of("evaluation-reliability", evaluation.reliability),
                            errors_table(evaluation),
                            sites_table(evaluation)};
  for (const LookEvaluation& looks : evaluation.of_samples) {
    for (Table& table : tables(looks)) all.push_back(std::move(table));
  }
  return all;
}

}  // namespace sightline

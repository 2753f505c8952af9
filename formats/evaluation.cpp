#include "formats/evaluation.h"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

// Names and places of the numbers of a row, in the order of dump and encoding.
template <class Row>
struct NumberField {
  const char* name;
  double Row::*value;
};
constexpr NumberField<StaticScore> kStaticFields[] = {
    {"range_m", &StaticScore::range_m},
    {"mean_error_m", &StaticScore::mean_error_m},
    {"mean_time_ms", &StaticScore::mean_time_ms},
    {"max_site_time_ms", &StaticScore::max_site_time_ms},
    {"max_run_time_ms", &StaticScore::max_run_time_ms},
    {"mean_work", &StaticScore::mean_work},
    {"r_squared", &StaticScore::r_squared},
    {"rmse_m", &StaticScore::rmse_m}};
constexpr NumberField<RuleScore> kRuleFields[] = {
    {"limit_m", &RuleScore::limit_m},
    {"coverage", &RuleScore::coverage},
    {"mean_error_m", &RuleScore::mean_error_m},
    {"p95_error_m", &RuleScore::p95_error_m},
    {"mean_range_m", &RuleScore::mean_range_m},
    {"time_ratio", &RuleScore::time_ratio},
    {"work_ratio", &RuleScore::work_ratio},
    {"mean_time_ms", &RuleScore::mean_time_ms},
    {"max_site_time_ms", &RuleScore::max_site_time_ms},
    {"max_run_time_ms", &RuleScore::max_run_time_ms},
    {"unmet_share", &RuleScore::unmet_share},
    {"extrapolated_share", &RuleScore::extrapolated_share},
    {"worst_coverage", &RuleScore::worst_coverage}};
constexpr NumberField<JudgedSite> kSiteFields[] = {{"s_m", &JudgedSite::s_m},
                                                   {"p_x_m", &JudgedSite::p_x_map_m},
                                                   {"p_y_m", &JudgedSite::p_y_map_m}};
constexpr NumberField<ReliabilityBin> kBinFields[] = {{"limit_m", &ReliabilityBin::limit_m},
                                                      {"promised", &ReliabilityBin::promised},
                                                      {"observed", &ReliabilityBin::observed}};

template <class Row, std::size_t kCount>
bool is_finite(const NumberField<Row> (&fields)[kCount], const Row& row) {
  return std::all_of(std::begin(fields), std::end(fields), [&](const NumberField<Row>& field) {
    return std::isfinite(row.*field.value);
  });
}

template <class Row, std::size_t kCount>
void append_names(const NumberField<Row> (&fields)[kCount], std::vector<std::string>& columns) {
  for (const NumberField<Row>& field : fields) columns.emplace_back(field.name);
}

template <class Row, std::size_t kCount>
void append_cells(const NumberField<Row> (&fields)[kCount], const Row& row,
                  std::vector<Cell>& cells) {
  for (const NumberField<Row>& field : fields) cells.emplace_back(row.*field.value);
}

template <class Row, std::size_t kCount>
void put_numbers(const NumberField<Row> (&fields)[kCount], const Row& row, ByteWriter& writer) {
  for (const NumberField<Row>& field : fields) writer.put(row.*field.value);
}

template <class Row, std::size_t kCount>
void get_numbers(const NumberField<Row> (&fields)[kCount], ByteReader& reader, Row& row) {
  for (const NumberField<Row>& field : fields) reader.get(row.*field.value);
}

Error invalid(const std::string& message, const std::string& place) {
  return {ErrorCode::kInvalidArtifact, message, "", place};
}

Result<void> validate_shape(const Evaluation& evaluation) {
  const std::size_t pairs = evaluation.sites.size() * evaluation.statics.size();
  const std::size_t rule_count = evaluation.limits_m.size() * kRuleCount;
  if (evaluation.sites.empty() || evaluation.statics.empty() || evaluation.limits_m.empty()) {
    return invalid("an evaluation needs judged sites, ranges and limits", "");
  }
  if (evaluation.rules.size() != rule_count || evaluation.error_m.size() != pairs ||
      evaluation.time_ms.size() != pairs ||
      evaluation.chosen_range_index.size() != rule_count * evaluation.sites.size()) {
    return invalid("scores or choices do not fill the judged sites, ranges and limits", "");
  }
  if (evaluation.out_of_fold_count > evaluation.sites.size() ||
      !std::isfinite(evaluation.stretch_m)) {
    return invalid("counts or the length of the worst stretch make no sense", "");
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
    if (!is_in_place || !are_shares || !is_finite(kRuleFields, score) ||
        score.worst_begin_site >= evaluation.site_count) {
      return invalid("a score is out of place or makes no sense", "rule " + std::to_string(i));
    }
  }
  return {};
}

Result<void> validate_sites(const Evaluation& evaluation) {
  for (std::size_t i = 0; i < evaluation.sites.size(); ++i) {
    const JudgedSite& site = evaluation.sites[i];
    const bool follows = i == 0 || evaluation.sites[i - 1].site < site.site;
    if (!follows || site.site >= evaluation.site_count || !is_finite(kSiteFields, site)) {
      return invalid("a judged site is out of order or place", "site " + std::to_string(i));
    }
  }
  for (const std::uint8_t index : evaluation.chosen_range_index) {
    if (index >= evaluation.statics.size()) return invalid("a chosen range is not there", "");
  }
  return {};
}

Table statics_table(const Evaluation& evaluation) {
  Table table;
  table.name = "evaluation-static-ranges";
  append_names(kStaticFields, table.columns);
  for (const StaticScore& score : evaluation.statics) {
    append_cells(kStaticFields, score, table.rows.emplace_back());
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
  for (const char* column : {"limit_m", "rule", "range_m", "error_m", "time_ms"}) {
    table.columns.emplace_back(column);
  }
  for (std::size_t i = 0; i < evaluation.sites.size(); ++i) {
    for (std::size_t row = 0; row < evaluation.rules.size(); ++row) {
      const std::size_t range = evaluation.chosen_range_index[row * evaluation.sites.size() + i];
      const std::size_t pair = i * evaluation.statics.size() + range;
      std::vector<Cell>& cells = table.rows.emplace_back();
      cells = {std::int64_t{evaluation.sites[i].site}, std::int64_t{evaluation.sites[i].run}};
      append_cells(kSiteFields, evaluation.sites[i], cells);
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

std::string_view rule_name(Rule rule) {
  constexpr std::string_view kNames[kRuleCount] = {
      "map", "mean", "probability", "static-equal-coverage", "static-longest", "oracle"};
  return kNames[static_cast<std::size_t>(rule)];
}

Result<void> validate(const Evaluation& evaluation) {
  Result<void> valid = validate_shape(evaluation);
  if (valid) valid = validate_rules(evaluation);
  if (valid) valid = validate_sites(evaluation);
  if (!valid) return valid;
  for (const StaticScore& score : evaluation.statics) {
    if (!is_finite(kStaticFields, score)) return invalid("a static score is not finite", "");
  }
  for (const ReliabilityBin& bin : evaluation.reliability) {
    if (!is_finite(kBinFields, bin)) return invalid("a reliability bin is not finite", "");
  }
  return {};
}

Table dump(const Evaluation& evaluation) {
  Table table;
  table.name = "evaluation";
  const bool is_known = evaluation.reference == ErrorReference::kKnownPose;
  table.facts = {{"drive", evaluation.drive},
                 {"reference", std::string(is_known ? "known-pose" : "full-range-match")},
                 {"site_count", std::int64_t{evaluation.site_count}},
                 {"judged_count", static_cast<std::int64_t>(evaluation.sites.size())},
                 {"out_of_fold_count", std::int64_t{evaluation.out_of_fold_count}},
                 {"stretch_m", evaluation.stretch_m}};
  table.columns = {"rule"};
  append_names(kRuleFields, table.columns);
  table.columns.emplace_back("worst_begin_site");
  for (const RuleScore& score : evaluation.rules) {
    std::vector<Cell>& cells = table.rows.emplace_back();
    cells.emplace_back(std::string(rule_name(score.rule)));
    append_cells(kRuleFields, score, cells);
    cells.emplace_back(std::int64_t{score.worst_begin_site});
  }
  return table;
}

std::vector<Table> tables(const Evaluation& evaluation) {
  return {dump(evaluation), statics_table(evaluation), reliability_table(evaluation),
          errors_table(evaluation), sites_table(evaluation)};
}

void encode(const Evaluation& evaluation, ByteWriter& writer) {
  writer.put_string(evaluation.drive);
  writer.put(evaluation.reference);
  writer.put(evaluation.site_count);
  writer.put(evaluation.out_of_fold_count);
  writer.put(evaluation.stretch_m);
  writer.put_array(evaluation.limits_m);
  writer.put<std::uint64_t>(evaluation.statics.size());
  for (const StaticScore& score : evaluation.statics) put_numbers(kStaticFields, score, writer);
  writer.put<std::uint64_t>(evaluation.rules.size());
  for (const RuleScore& score : evaluation.rules) {
    writer.put(score.rule);
    put_numbers(kRuleFields, score, writer);
    writer.put(score.worst_begin_site);
  }
  writer.put<std::uint64_t>(evaluation.reliability.size());
  for (const ReliabilityBin& bin : evaluation.reliability) {
    put_numbers(kBinFields, bin, writer);
    writer.put(bin.count);
  }
  writer.put<std::uint64_t>(evaluation.sites.size());
  for (const JudgedSite& site : evaluation.sites) {
    writer.put(site.site);
    writer.put(site.run);
    put_numbers(kSiteFields, site, writer);
  }
  writer.put_array(evaluation.error_m);
  writer.put_array(evaluation.time_ms);
  writer.put_array(evaluation.chosen_range_index);
}

void decode(ByteReader& reader, Evaluation& evaluation) {
  reader.get_string(evaluation.drive);
  reader.get(evaluation.reference);
  reader.get(evaluation.site_count);
  reader.get(evaluation.out_of_fold_count);
  reader.get(evaluation.stretch_m);
  reader.get_array(evaluation.limits_m);
  evaluation.statics.resize(reader.get_count(std::size(kStaticFields) * sizeof(double)));
  for (StaticScore& score : evaluation.statics) get_numbers(kStaticFields, reader, score);
  evaluation.rules.resize(reader.get_count(1 + std::size(kRuleFields) * sizeof(double) + 4));
  for (RuleScore& score : evaluation.rules) {
    reader.get(score.rule);
    if (static_cast<std::size_t>(score.rule) >= kRuleCount) return reader.fail();
    get_numbers(kRuleFields, reader, score);
    reader.get(score.worst_begin_site);
  }
  evaluation.reliability.resize(reader.get_count(std::size(kBinFields) * sizeof(double) + 4));
  for (ReliabilityBin& bin : evaluation.reliability) {
    get_numbers(kBinFields, reader, bin);
    reader.get(bin.count);
  }
  evaluation.sites.resize(reader.get_count(8 + std::size(kSiteFields) * sizeof(double)));
  for (JudgedSite& site : evaluation.sites) {
    reader.get(site.site);
    reader.get(site.run);
    get_numbers(kSiteFields, reader, site);
  }
  reader.get_array(evaluation.error_m);
  reader.get_array(evaluation.time_ms);
  reader.get_array(evaluation.chosen_range_index);
}

}  // namespace sightline

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "compiler/views/verdict/answered_shares.h"
#include "compiler/views/verdict/evaluation_figures.h"
#include "formats/base/files/atomic_file.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

using Json = nlohmann::json;

// A table of the file; its columns are found by name. Functions throw what nlohmann::json throws.
class JsonTable {
 public:
  explicit JsonTable(const Json& table) : table_(table) {}

  [[nodiscard]] const Json& rows() const { return table_.at("rows"); }
  [[nodiscard]] const Json& fact(const char* name) const { return table_.at("facts").at(name); }
  // Empty where the file has no such fact.
  [[nodiscard]] std::string text_fact(const char* name) const {
    return table_.at("facts").value(name, std::string());
  }
  [[nodiscard]] const Json& cell(const Json& row, const char* column) const {
    const Json& columns = table_.at("columns");
    const auto found = std::ranges::find(columns, column);
    if (found == columns.end()) throw std::invalid_argument(concat("no column \"", column, "\""));
    return row.at(static_cast<std::size_t>(found - columns.begin()));
  }
  [[nodiscard]] double number(const Json& row, const char* column) const {
    return cell(row, column).get<double>();
  }
  [[nodiscard]] bool is(const Json& row, const char* column, const std::string& text) const {
    return cell(row, column).get<std::string>() == text;
  }

 private:
  const Json& table_;
};

std::optional<JsonTable> find_table(const Json& tables, const std::string& name) {
  for (const Json& table : tables) {
    if (table.at("name") == name) return JsonTable(table);
  }
  return std::nullopt;
}

std::optional<AnswerKind> kind_named(const std::string& rule) {
  if (rule == "map") return AnswerKind::kRange;
  if (rule == "look") return AnswerKind::kLook;
  if (rule == "plan") return AnswerKind::kPlan;
  return std::nullopt;
}

LimitFigures& at_limit(EvaluationFigures& figures, double limit_m) {
  const auto found = std::ranges::find(figures.limits, limit_m, &LimitFigures::limit_m);
  if (found == figures.limits.end()) {
    throw std::invalid_argument(concat("no limit of ", format_double(limit_m), " m"));
  }
  return *found;
}

// Of the tables of a drive that was replayed.
void add_replay(const CompiledMap& map, const JsonTable& replay, const JsonTable& scans,
                EvaluationFigures& figures) {
  figures.scan_count = replay.fact("scan_count").get<std::uint32_t>();
  AnsweredShares answered(map);
  for (const Json& row : scans.rows()) {
    const std::optional<AnswerKind> kind = kind_named(scans.cell(row, "rule").get<std::string>());
    if (!kind) continue;
    answered.add_scan(*kind, scans.number(row, "limit_m"),
                      {scans.number(row, "p_x_m"), scans.number(row, "p_y_m")},
                      scans.number(row, "error_m"));
  }
  for (const Json& row : replay.rows()) {
    const double limit_m = replay.number(row, "limit_m");
    const double coverage = replay.number(row, "coverage");
    const double time_ratio = replay.number(row, "time_ratio");
    const double work_ratio = replay.number(row, "work_ratio");
    const auto lost = replay.cell(row, "lost_count").get<std::uint32_t>();
    LimitFigures& limit = at_limit(figures, limit_m);
    const std::optional<AnswerKind> kind = kind_named(replay.cell(row, "rule").get<std::string>());
    if (kind) {
      limit.answers.push_back(
          {*kind, coverage, answered.share(*kind, limit_m), time_ratio, work_ratio, lost});
    } else {
      const auto look = replay.cell(row, "look").get<std::string>();
      limit.constants.push_back({look, coverage, time_ratio, work_ratio, lost});
    }
  }
}

void add_looks(const CompiledMap& map, const Json& tables, EvaluationFigures& figures) {
  const std::optional<JsonTable> statics = find_table(tables, "evaluation-static-looks");
  const std::optional<JsonTable> rules = find_table(tables, "evaluation-looks");
  if (!statics || !rules) return;
  for (const Json& row : statics->rows()) {
    at_limit(figures, statics->number(row, "limit_m"))
        .constants.push_back({statics->cell(row, "look").get<std::string>(),
                              statics->number(row, "coverage"),
                              statics->number(row, "time_ratio"),
                              statics->number(row, "work_ratio"),
                              {}});
  }
  for (const Json& row : rules->rows()) {
    if (!map.looks || !rules->is(row, "rule", "map")) continue;
    LimitFigures& limit = at_limit(figures, rules->number(row, "limit_m"));
    const auto index = static_cast<std::size_t>(&limit - figures.limits.data());
    const double coverage = rules->number(row, "coverage");
    limit.answers.push_back({AnswerKind::kLook,
                             coverage,
                             answered_coverage_of_looks(map, index, coverage),
                             rules->number(row, "time_ratio"),
                             rules->number(row, "work_ratio"),
                             {}});
  }
}

// Of the tables of a drive that was not replayed.
void add_sites(const CompiledMap& map, const Json& tables, const JsonTable& rules,
               EvaluationFigures& figures) {
  add_looks(map, tables, figures);
  AnsweredShares answered(map);
  if (const std::optional<JsonTable> sites = find_table(tables, "evaluation-sites")) {
    for (const Json& row : sites->rows()) {
      if (!sites->is(row, "rule", "map")) continue;
      answered.add_site(AnswerKind::kRange, sites->number(row, "limit_m"),
                        sites->cell(row, "site").get<std::size_t>(), sites->number(row, "error_m"));
    }
  }
  const bool has_looks = find_table(tables, "evaluation-static-looks").has_value();
  for (const Json& row : rules.rows()) {
    const double limit_m = rules.number(row, "limit_m");
    const double coverage = rules.number(row, "coverage");
    const double time_ratio = rules.number(row, "time_ratio");
    const double work_ratio = rules.number(row, "work_ratio");
    LimitFigures& limit = at_limit(figures, limit_m);
    if (rules.is(row, "rule", "map")) {
      limit.answers.push_back({AnswerKind::kRange,
                               coverage,
                               answered.share(AnswerKind::kRange, limit_m),
                               time_ratio,
                               work_ratio,
                               {}});
    } else if (!has_looks && (rules.is(row, "rule", "static-equal-coverage") ||
                              rules.is(row, "rule", "static-longest"))) {
      limit.constants.push_back({fixed(rules.number(row, "mean_range_m"), 0) + " m",
                                 coverage,
                                 time_ratio,
                                 work_ratio,
                                 {}});
    }
  }
}

// Without figures at the limits.
EvaluationFigures head_of(const JsonTable& rules) {
  EvaluationFigures figures;
  figures.drive = rules.fact("drive").get<std::string>();
  figures.is_simulated = rules.fact("reference") == "simulated";
  figures.origin = origin_named(rules.text_fact("drive_role"));
  figures.map_id = rules.text_fact("map_id");
  figures.root_digest = rules.text_fact("root_digest");
  figures.site_count = rules.fact("site_count").get<std::uint32_t>();
  figures.judged_count = rules.fact("judged_count").get<std::uint32_t>();
  for (const Json& row : rules.rows()) {
    if (rules.is(row, "rule", "map")) {
      figures.limits.push_back({rules.number(row, "limit_m"), {}, {}});
    }
  }
  return figures;
}

Result<void> check_map(const EvaluationFigures& figures, const CompiledMap& map) {
  if (!figures.map_id.empty() && figures.map_id != map.map_id) {
    return Error{
        ErrorCode::kMismatchedInputs,
        concat("the evaluation is of the map ", figures.map_id, ", this map is ", map.map_id,
               ". Evaluate this map: `sightline evaluate CONFIG --map MAP "
               "--json FILE`")};
  }
  const bool fits = figures.site_count == map.sites.sites.size() &&
                    std::ranges::equal(figures.limits, map.ranges.promises, {},
                                       &LimitFigures::limit_m, &LimitPromise::limit_m);
  if (fits) return {};
  return Error{ErrorCode::kMismatchedInputs,
               concat("the evaluation is of a map with ", figures.site_count, " sites and ",
                      figures.limits.size(), " limits, this map has ", map.sites.sites.size(),
                      " sites and ", map.ranges.promises.size(),
                      " limits, or its limits differ. Evaluate this map: `sightline evaluate "
                      "CONFIG --map MAP --json FILE`")};
}

Result<EvaluationFigures> figures_of(const Json& tables, const CompiledMap& map) {
  const std::optional<JsonTable> rules = find_table(tables, "evaluation");
  if (!rules) throw std::invalid_argument("no table \"evaluation\"");
  EvaluationFigures figures = head_of(*rules);
  SIGHTLINE_TRY(check_map(figures, map));
  const std::optional<JsonTable> replay = find_table(tables, "continuous-localization");
  const std::optional<JsonTable> scans = find_table(tables, "continuous-localization-scans");
  if (replay && scans) {
    add_replay(map, *replay, *scans, figures);
  } else {
    add_sites(map, tables, *rules, figures);
  }
  for (LimitFigures& limit : figures.limits) {
    std::ranges::sort(limit.answers, {}, &AnswerScore::kind);
  }
  return figures;
}

}  // namespace

Result<EvaluationFigures> parse_evaluation(std::string_view json, const CompiledMap& map) {
  try {
    return figures_of(Json::parse(json), map);
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kMalformedText,
                 std::string("expected what evaluate --json writes: ") + exception.what()};
  }
}

Result<EvaluationFigures> read_evaluation(const std::filesystem::path& file,
                                          const CompiledMap& map) {
  SIGHTLINE_ASSIGN(const std::string text, read_text_file(file));
  Result<EvaluationFigures> figures = parse_evaluation(text, map);
  if (!figures) return in_file(figures.error(), file.string());
  return figures;
}

}  // namespace sightline

#include "compiler/gate/rules/rules.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "formats/base/files/atomic_file.h"
#include "formats/grid/point_grid.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

using enum Severity;
using enum Needs;
using enum Bound;

// Findings about the exceptions themselves.
const GateRule kRulesOfExceptions[] = {
    {"exception-expired", kExceptions, kWarning, kAtMost, 0.0, "days",
     "An exception has expired and no longer applies", nullptr},
    {"exception-unused", kExceptions, kNote, kAtMost, 0.0, "exceptions",
     "An exception that has not expired covers no finding", nullptr},
};

Eigen::Vector3d p_world_m(const CompiledMap& map, std::size_t site) {
  return map.sites.frame.world_m(map.sites.sites[site].p_map_m);
}

std::vector<std::optional<std::uint32_t>> nearest_of(const CompiledMap& from,
                                                     const CompiledMap& to) {
  std::vector<Eigen::Vector3d> places_m;
  for (std::size_t site = 0; site < to.sites.sites.size(); ++site) {
    places_m.push_back(p_world_m(to, site));
  }
  const PointGrid grid(places_m);
  std::vector<std::optional<std::uint32_t>> found(from.sites.sites.size());
  for (std::size_t site = 0; site < found.size(); ++site) {
    const std::optional<NearPoint> nearest =
        grid.nearest_on_level(p_world_m(from, site), to.reach_m);
    if (nearest) found[site] = static_cast<std::uint32_t>(nearest->index);
  }
  return found;
}

std::vector<GateRule> join() {
  std::vector<GateRule> all;
  for (const std::span<const GateRule> part :
       {rules_of_map(), rules_of_observation(), rules_of_identity(), rules_of_change(),
        std::span<const GateRule>(kRulesOfExceptions)}) {
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

using Json = nlohmann::json;

// One of the tables that evaluate writes; null where it is not there.
const Json* find_table(const Json& tables, std::string_view name) {
  for (const Json& table : tables) {
    if (table.at("name") == name) return &table;
  }
  return nullptr;
}

const Json& evaluation_table(const Json& tables) {
  const Json* table = find_table(tables, "evaluation");
  if (table == nullptr) throw std::invalid_argument("no table \"evaluation\"");
  return *table;
}

const Json& cell(const Json& table, const Json& row, const std::string& column) {
  const Json& columns = table.at("columns");
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] == column) return row.at(i);
  }
  throw std::invalid_argument(concat("no column \"", column, "\""));
}

bool has_column(const Json& table, std::string_view column) {
  const Json& columns = table.at("columns");
  return std::ranges::find(columns, column) != columns.end();
}

ObservedLimit read_limit(const Json& table, const Json& row) {
  const auto number = [&](const char* column) { return cell(table, row, column).get<double>(); };
  return {number("limit_m"),
          number("coverage"),
          number("mean_range_m"),
          number("time_ratio"),
          number("work_ratio"),
          number("worst_coverage"),
          cell(table, row, "worst_begin_site").get<std::uint32_t>(),
          has_column(table, "answered_miss_share") ? 1.0 - number("answered_miss_share")
                                                   : number("coverage")};
}

// The map's own looks at the judged sites.
std::vector<ObservedAnswer> read_looks(const Json& tables) {
  std::vector<ObservedAnswer> looks;
  const Json* table = find_table(tables, "evaluation-looks");
  if (table == nullptr) return looks;
  for (const Json& row : table->at("rows")) {
    if (cell(*table, row, "rule") != "map") continue;
    looks.push_back({"look", cell(*table, row, "limit_m").get<double>(),
                     cell(*table, row, "coverage").get<double>(),
                     cell(*table, row, "time_ratio").get<double>(), 0});
  }
  return looks;
}

// The map's answers along the whole drive.
std::vector<ObservedAnswer> read_replayed(const Json& tables) {
  std::vector<ObservedAnswer> replayed;
  const Json* table = find_table(tables, "continuous-localization");
  if (table == nullptr) return replayed;
  for (const Json& row : table->at("rows")) {
    if (cell(*table, row, "rule") == "static") continue;
    replayed.push_back(
        {cell(*table, row, "rule").get<std::string>(), cell(*table, row, "limit_m").get<double>(),
         cell(*table, row, "coverage").get<double>(), cell(*table, row, "time_ratio").get<double>(),
         cell(*table, row, "lost_count").get<std::uint32_t>()});
  }
  return replayed;
}

}  // namespace

SitePairs pair_sites(const CompiledMap& new_map, const CompiledMap& old_map) {
  return {nearest_of(new_map, old_map), nearest_of(old_map, new_map)};
}

std::optional<double> Threshold::at(std::optional<double> limit_m) const {
  for (const auto& [of_limit_m, value] : at_limits) {
    if (limit_m && *limit_m == of_limit_m) return value;
  }
  return allowed;
}

bool is_within(double value, Bound bound, double allowed) {
  // Sums of the same numbers in another order end a little apart; a threshold is not meant to catch
  // that.
  constexpr double kSlack = 1e-9;
  return bound == Bound::kAtMost ? value <= allowed + kSlack : value >= allowed - kSlack;
}

std::string in_words(double value, std::string_view unit) {
  if (unit == "share") return percent(value);
  if (unit == "of the longest") return fixed(value, 3) + " of the longest";
  if (unit == "of the limit") return fixed(value, 2) + " of the limit";
  if (unit == "m") return fixed(value, value < 1.0 && value > -1.0 ? 3 : 1) + " m";
  if (unit == "nat" || unit == "deg") {
    return fixed(value, 3) + (unit == "deg" ? " degrees" : " nat");
  }
  if (unit.empty()) return fixed(value, 2);
  const std::string count = fixed(value, 0);
  const bool is_one = count == "1" && unit.ends_with('s');
  return concat(count, " ", is_one ? unit.substr(0, unit.size() - 1) : unit);
}

std::string within(double limit_m) { return concat(" within ", format_double(limit_m), " m"); }

std::vector<Found> of_whole_map(double value, std::string message) {
  return {{std::nullopt, std::nullopt, value, std::move(message)}};
}

std::vector<Found> not_judged(std::string why) {
  return {{std::nullopt, std::nullopt, 0.0, std::move(why), false}};
}

std::span<const GateRule> gate_rules() {
  static const std::vector<GateRule> kAll = join();
  return kAll;
}

std::string rules_table() {
  std::string text = "| rule | severity | allowed | what is judged |\n|---|---|---|---|\n";
  for (const GateRule& rule : gate_rules()) {
    const std::string side = rule.bound == Bound::kAtMost ? "at most " : "at least ";
    text += concat("| `", rule.id, "` | ", severity_name(rule.severity), " | ",
                   (rule.allowed ? side + in_words(*rule.allowed, rule.unit) : "no bound"), " | ",
                   rule.summary, " |\n");
  }
  return text;
}

std::string_view severity_name(Severity severity) {
  static constexpr std::array<std::string_view, 3> kNames = {"note", "warning", "error"};
  return kNames[static_cast<std::size_t>(severity)];
}

std::string_view verdict_name(Verdict verdict) {
  static constexpr std::array<std::string_view, 4> kNames = {"met", "violated", "excepted",
                                                             "not-judged"};
  return kNames[static_cast<std::size_t>(verdict)];
}

std::size_t GateReport::count(Verdict wanted) const {
  return static_cast<std::size_t>(std::ranges::count(checks, wanted, &Check::verdict));
}

std::size_t GateReport::violations(Severity severity) const {
  return static_cast<std::size_t>(std::ranges::count_if(checks, [&](const Check& check) {
    return check.verdict == Verdict::kViolated && check.severity == severity;
  }));
}

bool GateReport::passes() const {
  return std::ranges::none_of(checks, [&](const Check& check) {
    return check.verdict == Verdict::kViolated && check.severity >= fails_at;
  });
}

Result<Observation> parse_observation(std::string_view json) {
  try {
    const Json tables = Json::parse(json);
    const Json& table = evaluation_table(tables);
    const Json& facts = table.at("facts");
    Observation observation;
    observation.drive = facts.at("drive").get<std::string>();
    observation.site_count = facts.at("site_count").get<std::uint32_t>();
    observation.stretch_m = facts.at("stretch_m").get<double>();
    for (const Json& row : table.at("rows")) {
      if (cell(table, row, "rule") == "map") observation.limits.push_back(read_limit(table, row));
    }
    observation.looks = read_looks(tables);
    observation.replayed = read_replayed(tables);
    observation.origin = origin_named(facts.value("drive_role", std::string()));
    observation.root_digest = facts.value("root_digest", std::string());
    return observation;
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kMalformedText,
                 std::string("found no JSON of `sightline evaluate --json`: ") + exception.what()};
  }
}

Result<Observation> read_observation(const std::filesystem::path& file) {
  SIGHTLINE_ASSIGN(const std::string text, read_text_file(file));
  Result<Observation> observation = parse_observation(text);
  if (!observation) return in_file(observation.error(), file.string());
  return observation;
}

}  // namespace sightline

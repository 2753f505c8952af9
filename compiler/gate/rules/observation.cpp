#include "compiler/gate/rules/observation.h"

#include <nlohmann/json.hpp>

#include "formats/base/files/atomic_file.h"

namespace sightline {
namespace {

using Json = nlohmann::json;

// The table of rules: "evaluation" among the tables that evaluate writes.
const Json& rules_table(const Json& tables) {
  for (const Json& table : tables) {
    if (table.at("name") == "evaluation") return table;
  }
  throw std::invalid_argument("there is no table \"evaluation\"");
}

const Json& cell(const Json& table, const Json& row, const std::string& column) {
  const Json& columns = table.at("columns");
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] == column) return row.at(i);
  }
  throw std::invalid_argument("there is no column \"" + column + "\"");
}

ObservedLimit read_limit(const Json& table, const Json& row) {
  const auto number = [&](const char* column) { return cell(table, row, column).get<double>(); };
  return {number("limit_m"),
          number("coverage"),
          number("mean_range_m"),
          number("time_ratio"),
          number("work_ratio"),
          number("worst_coverage"),
          cell(table, row, "worst_begin_site").get<std::uint32_t>()};
}

}  // namespace

Result<Observation> parse_observation(std::string_view json) {
  try {
    const Json tables = Json::parse(json);
    const Json& table = rules_table(tables);
    const Json& facts = table.at("facts");
    Observation observation;
    observation.drive = facts.at("drive").get<std::string>();
    observation.site_count = facts.at("site_count").get<std::uint32_t>();
    observation.stretch_m = facts.at("stretch_m").get<double>();
    for (const Json& row : table.at("rows")) {
      if (cell(table, row, "rule") == "map") observation.limits.push_back(read_limit(table, row));
    }
    return observation;
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kMalformedText,
                 std::string("expected what evaluate --json writes: ") + exception.what()};
  }
}

Result<Observation> read_observation(const std::filesystem::path& file) {
  SIGHTLINE_ASSIGN(const std::string text, read_text_file(file));
  Result<Observation> observation = parse_observation(text);
  if (!observation) return in_file(observation.error(), file.string());
  return observation;
}

}  // namespace sightline

#include "formats/annotation/site_column.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace sightline {
namespace {

bool is_name(const std::string& name) {
  constexpr std::size_t kLongest = 60;
  return !name.empty() && name.size() <= kLongest && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

bool is_unit(const std::string& unit) {
  constexpr std::size_t kLongest = 20;
  return unit.size() <= kLongest &&
         std::ranges::all_of(unit, [](char c) { return c > ' ' && c <= '~'; });
}

Result<void> validate_steps(const SiteColumn& column) {
  const bool ascends = std::ranges::adjacent_find(column.steps, std::ranges::greater_equal()) ==
                           column.steps.end() &&
                       std::ranges::none_of(column.steps, [](float x) { return std::isnan(x); });
  if (column.steps.size() <= kMostColumnSteps && ascends) return {};
  return Error{ErrorCode::kInvalidArtifact,
               column.name + " needs at most 256 possible values, which ascend"};
}

}  // namespace

std::size_t step_of(const SiteColumn& column, float value) {
  const auto found = std::ranges::lower_bound(column.steps, value);
  return found == column.steps.end() ? kMostColumnSteps
                                     : static_cast<std::size_t>(found - column.steps.begin());
}

Result<void> validate(const SiteColumn& column) {
  if (!is_name(column.name) || !is_unit(column.unit)) {
    return Error{ErrorCode::kInvalidArtifact,
                 "the name of a column needs 1 to 60 characters of a-z, 0-9 and _, and its unit at "
                 "most 20 printable characters"};
  }
  SIGHTLINE_TRY(validate_steps(column));
  for (std::size_t site = 0; site < column.values.size(); ++site) {
    const float value = column.values[site];
    const bool is_step = column.steps.empty() || std::ranges::binary_search(column.steps, value);
    if (!std::isnan(value) && is_step) continue;
    return Error{ErrorCode::kInvalidArtifact,
                 column.name + (is_step ? " is not a number" : " has a value that its steps lack"),
                 "", concat("site ", site)};
  }
  return {};
}

Table dump(const SiteColumn& column) {
  Table table{column.name, {"site", column.name}, {}, {}};
  for (std::size_t site = 0; site < column.values.size(); ++site) {
    table.rows.push_back({static_cast<std::int64_t>(site), double{column.values[site]}});
  }
  return table;
}

Table dump(const std::vector<SiteColumn>& columns) {
  Table table{"columns", {"site"}, {}, {}};
  for (const SiteColumn& column : columns) {
    table.columns.push_back(column.name);
    table.rows.resize(column.values.size());
    for (std::size_t site = 0; site < column.values.size(); ++site) {
      if (table.rows[site].empty()) table.rows[site].emplace_back(static_cast<std::int64_t>(site));
      table.rows[site].emplace_back(double{column.values[site]});
    }
  }
  return table;
}

}  // namespace sightline

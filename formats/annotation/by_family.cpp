#include "formats/annotation/by_family.h"

#include <algorithm>
#include <iterator>

namespace sightline::by_family {
namespace {

Error invalid(const std::string& message) {
  return {ErrorCode::kInvalidArtifact, message, "", "samples"};
}

}  // namespace

Result<void> validate_looks(const std::vector<Look>& ranges, const std::vector<Look>& samples) {
  if (std::ranges::all_of(ranges, takes_every_return) &&
      std::ranges::none_of(samples, takes_every_return)) {
    return {};
  }
  return invalid("a look of this kind belongs in the other table");
}

Error of_other_sites() {
  return invalid("the table of looks that take a sample is of other sites");
}

void append_samples(Table samples, Table& table) {
  for (auto& [name, value] : samples.facts) {
    if (name.starts_with("limit_")) table.facts.emplace_back("look_" + name, std::move(value));
  }
  // A cell that a table has no factor for stays empty.
  table.columns = std::move(samples.columns);
  table.rows.insert(table.rows.end(), std::make_move_iterator(samples.rows.begin()),
                    std::make_move_iterator(samples.rows.end()));
  for (std::vector<Cell>& row : table.rows) row.resize(table.columns.size(), std::string());
}

}  // namespace sightline::by_family

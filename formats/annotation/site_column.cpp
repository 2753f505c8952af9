#include "formats/annotation/site_column.h"

#include <cmath>

namespace sightline {

Result<void> validate(const SiteColumn& column) {
  if (column.name.empty()) {
    return Error{ErrorCode::kInvalidArtifact, "found a column without a name"};
  }
  for (std::size_t site = 0; site < column.values.size(); ++site) {
    if (!std::isnan(column.values[site])) continue;
    return Error{ErrorCode::kInvalidArtifact, column.name + " is not a number", "",
                 "site " + std::to_string(site)};
  }
  return {};
}

Table dump(const SiteColumn& column) {
  Table table{column.name, {"site", column.name}, {}, {}};
  for (std::size_t site = 0; site < column.values.size(); ++site) {
    table.rows.push_back({static_cast<std::int64_t>(site), column.values[site]});
  }
  return table;
}

}  // namespace sightline

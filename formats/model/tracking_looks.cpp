#include "formats/model/tracking_looks.h"

#include "formats/record/fields.h"

namespace sightline {

Result<void> validate(const TrackingLooks& looks) {
  for (const SiteColumn& column : looks.columns) {
    SIGHTLINE_TRY(validate(column));
    if (column.values.size() == looks.columns.front().values.size()) continue;
    return invalid_artifact("columns are of different sites", column.name);
  }
  return {};
}

Table dump(const TrackingLooks& looks) {
  Table table = dump(looks.columns);
  table.name = "tracking-looks";
  for (std::size_t limit = 0; limit < looks.promises.size(); ++limit) {
    table.facts.emplace_back(concat("promise_", limit), looks.promises[limit]);
  }
  return table;
}

}  // namespace sightline

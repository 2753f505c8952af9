#pragma once

#include <string>
#include <vector>

#include "formats/annotation/site_column.h"
#include "formats/artifact.h"
#include "formats/record/fields.h"

namespace sightline {

// The look of each site for a vehicle that starts the matcher as one that tracks ("Looks while
// tracking" in schemas/definitions.md).
struct TrackingLooks {
  // For each limit those of formats/reader/site_looks.h; none where the model has no errors from
  // tracking starts.
  std::vector<SiteColumn> columns;
  std::vector<std::string> promises;  // [limit]: for people
};
SIGHTLINE_FIELDS(TrackingLooks, columns, promises)
SIGHTLINE_ARTIFACT(TrackingLooks, "tracking-looks", 1)

// Errors: those of validate(SiteColumn); invalid-artifact where columns differ in size.
Result<void> validate(const TrackingLooks& looks);
Table dump(const TrackingLooks& looks);

}  // namespace sightline

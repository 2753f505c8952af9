#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "formats/artifact.h"
#include "formats/record/fields.h"

namespace sightline {

// One number for every site: the output of a pass that measures something at each place. Maps keep
// columns, and readers, exports, differences and reports show them without further code.
struct SiteColumn {
  std::string name;           // 1 to 60 of a-z, 0-9 and _, with its unit: "clearance_m"
  std::string unit;           // for people: "m", "m/s"; empty: none
  std::vector<float> values;  // [site]; +-inf where there is none
  // The values that a site may have, ascending: a map then takes 1 byte a site instead of 4. Empty:
  // any value.
  std::vector<float> steps = {};
};
SIGHTLINE_FIELDS(SiteColumn, name, unit, values, steps)
SIGHTLINE_ARTIFACT(SiteColumn, "site-column", 3)

inline constexpr std::size_t kMostColumnSteps = 256;

// Number of the step that a value is. A value that is none: the next greater one, or
// kMostColumnSteps.
std::size_t step_of(const SiteColumn& column, float value);

// The column of the pass count-removed: share of the returns around a site that were removed as
// moving.
inline constexpr std::string_view kRemovedShare = "removed_share";

// Error: invalid-artifact (a name or unit of another form, a value that is no number or no step, or
// steps that do not ascend or are too many).
Result<void> validate(const SiteColumn& column);
Table dump(const SiteColumn& column);  // site, and a column of that name
// All of one map as a table: site, and a column each.
Table dump(const std::vector<SiteColumn>& columns);

}  // namespace sightline

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "formats/artifact.h"
#include "formats/record/fields.h"

namespace sightline {

// One number for every site: what a pass makes that measures something at each place.
struct SiteColumn {
  std::string name;            // unit included: "clearance_m"
  std::vector<double> values;  // [site]; +-inf where there is none
};
SIGHTLINE_FIELDS(SiteColumn, name, values)

template <>
struct ArtifactTraits<SiteColumn> {
  static constexpr std::string_view kName = "site-column";
  static constexpr std::uint32_t kVersion = 1;
};

// Error: invalid-artifact (no name, a value that is no number).
Result<void> validate(const SiteColumn& column);
Table dump(const SiteColumn& column);  // site, and a column of that name

}  // namespace sightline

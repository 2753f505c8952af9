#pragma once

#include "formats/annotation/site_column.h"
#include "formats/annotation/sites.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/pass/pass.h"

// A pass of your own, complete: options, one free function, and what it says of itself. The steps
// of passes/README.md point into this folder.

namespace sightline {

// Step 1, the options: each field once, with its unit, help and bounds.
struct MeasureClearanceOptions {
  double reach_m = 20.0;
  double lowest_m = -1.0;  // heights relative to the sensor
  double highest_m = 1.0;
};
std::vector<OptionField> option_fields(MeasureClearanceOptions& options);

// Step 2, the pass: how much room there is beside the route. The horizontal distance (m) from each
// site to the nearest vertical plane (a class 2 ND whose normal is within 30 degrees of level) with
// its mean between lowest_m and highest_m; +inf where none stands within reach_m.
// Errors: mismatched-inputs (sites and map in different frames).
Result<SiteColumn> measure_clearance(PassContext& ctx, const MeasureClearanceOptions& options,
                                     const NdtMap& map, const Sites& sites);
inline constexpr Pass kMeasureClearance =
    Pass{"measure-clearance", 1, "clearance", "Room beside the route", &measure_clearance}.in(
        Stage::kSites);

}  // namespace sightline

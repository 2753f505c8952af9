#pragma once

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/drive/sensor_profile.h"
#include "formats/tables/stored_table.h"
#include "passes/pass/pass.h"

namespace sightline {

// The factors of a map and two more: how far off the scans that made the map end when they are
// localized in it, measured as `own` at these sites. It is known before any other drive, and
// contains what a virtual scan lacks: clutter, dropouts, what was removed as moving. `own_error`
// (m), measured as the localization drive is: evidence that a choice is held against.
// `mapping_error` (m), measured from the poses that made the map: for models to learn from.
// `virtual_error` is used in place of both at sites that were not measured, and everywhere, which a
// warning says, where the mapping sensor is not the one that will localize. `mapping_sensor` is
// null where a model is to learn from other scans of the drive that made the map: these are too
// alike, so `mapping_error` is `virtual_error` everywhere.
//
// In a finished map `own` is of simulated scans: their error is `mapping_error`, and twice their
// error is `own_error`, since simulated errors are optimistic. A column `simulated` of ones marks
// the sites; a model without that column does not take such a map.
//
// Looks that take a sample get a table of their own: the factors of the longest range, `own_error`
// and `mapping_error` of each look, mean and greatest `mapping_error` of all looks, the look's
// number, and `match_cost`, what a localization by it costs, in matched points. Definition:
// schemas/definitions.md, "Factor from the mapping drive". Errors: mismatched-inputs (other sites
// or ranges, no virtual_error); disk-full or cannot-write (a temporary file).
Result<ByFamily<StoredTable<FactorTable>>> add_mapping_error(
    PassContext& ctx, const NoOptions& options, const StoredTable<FactorTable>& map_factors,
    const ByFamily<StoredTable<MeasuredError>>& own, const SensorProfile* mapping_sensor,
    const SensorProfile& localizing_sensor);
inline constexpr Pass kAddMappingError =
    Pass{"add-mapping-error", 4, "factors", "Factor: error of the mapping scans",
         &add_mapping_error}
        .in(Stage::kSites);

}  // namespace sightline

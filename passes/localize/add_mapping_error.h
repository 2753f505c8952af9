#pragma once

#include <vector>

#include "formats/annotation/at_rest.h"
#include "formats/drive/sensor_profile.h"
#include "passes/pass/pass.h"

namespace sightline {

// The factors of a map and two more: how far off the scans that made the map end when they are
// localized in it, as `own` of these sites found. It is known before any other drive, and sees what
// a virtual scan does not: clutter, dropouts, what was removed as moving. `own_error` (m), judged
// as the localization drive is: evidence that a choice is held against. `mapping_error` (m), judged
// by the poses that they made the map with: for models to learn from.
// `virtual_error` stands in at sites that were not measured, and everywhere, which a warning says,
// where the mapping sensor is not the one that will localize. Looks that take a sample get a table
// of their own (FactorTable::of_samples): the factors of the longest range, `own_error` and
// `mapping_error` of each look, mean and greatest `mapping_error` of all looks, the look's number,
// and `match_cost`, what a localization by it costs, in matched points. Definition:
// schemas/definitions.md, "Factor from the mapping drive". Errors: mismatched-inputs (other sites
// or ranges, no virtual_error); disk-full or cannot-write (a temporary file), as of all here.
Result<AtRest<FactorTable>> add_mapping_error(PassContext& ctx, const NoOptions& options,
                                              const AtRest<FactorTable>& map_factors,
                                              const AtRest<MeasuredError>& own,
                                              const SensorProfile& mapping_sensor,
                                              const SensorProfile& localizing_sensor);
inline constexpr Pass kAddMappingError =
    Pass{"add-mapping-error", 4, "factors", "The factor from the mapping drive", &add_mapping_error}
        .in(Stage::kSites);

// The same where a model is to learn from a drive that both makes the map and is localized in it:
// its halves know too much of each other, so `mapping_error` is `virtual_error` everywhere.
Result<AtRest<FactorTable>> add_own_error(PassContext& ctx, const NoOptions& options,
                                          const AtRest<FactorTable>& map_factors,
                                          const AtRest<MeasuredError>& own);
inline constexpr Pass kAddOwnError = variant_of(kAddMappingError, &add_own_error);

// The same of a finished map that nobody scanned: what simulated scans found stands for both, look
// by look, and twice as much of it for `own_error`, since it flatters. A column `simulated` of ones
// says so. A model that learnt with that column judges such maps as it judges those that taught it;
// one without it does not. Error: mismatched-inputs.
Result<AtRest<FactorTable>> add_simulated_error(PassContext& ctx, const NoOptions& options,
                                                const AtRest<FactorTable>& map_factors,
                                                const AtRest<MeasuredError>& simulated);
inline constexpr Pass kAddSimulatedError = variant_of(kAddMappingError, &add_simulated_error);

}  // namespace sightline

#pragma once

#include <vector>

#include "compiler/pipeline/options.h"
#include "compiler/pipeline/pass_context.h"
#include "formats/factor_table.h"
#include "formats/measured_error.h"
#include "formats/sensor_profile.h"

namespace sightline {

inline constexpr std::uint32_t kAddMappingErrorVersion = 1;

struct AddMappingErrorOptions {};
std::vector<OptionField> option_fields(AddMappingErrorOptions& options);

// The factors of a map and one more, `mapping_error` (m): how far off the scans that made the map
// end when they are localized in it, as `measured` of these sites found. It is known before any
// other drive, and sees what a virtual scan does not: clutter, dropouts, what was removed as moving.
// `virtual_error` stands in at sites that were not measured, and everywhere, which a warning says,
// where the mapping sensor is not the one that will localize. Definition: schemas/definitions.md,
// "Factor from the mapping drive". Error: mismatched-inputs (other sites or ranges, no
// virtual_error).
Result<FactorTable> add_mapping_error(PassContext& ctx, const AddMappingErrorOptions& options,
                                      const FactorTable& map_factors, const MeasuredError& measured,
                                      const SensorProfile& mapping_sensor,
                                      const SensorProfile& localizing_sensor);

// The same where a model is to learn from a drive that both makes the map and is localized in it:
// its halves know too much of each other, so `virtual_error` stands in everywhere.
Result<FactorTable> add_no_mapping_error(PassContext& ctx, const AddMappingErrorOptions& options,
                                         const FactorTable& map_factors);

}  // namespace sightline

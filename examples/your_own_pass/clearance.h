#pragma once

#include <vector>

#include "compiler/pipeline/options.h"
#include "compiler/pipeline/pass_context.h"
#include "formats/ndt_map.h"
#include "formats/sites.h"

// A pass of your own, complete: an artifact, options, and one free function. The README's six
// steps point into this folder.

namespace sightline {

// Step 1, the artifact: how much room there is beside the route at every site.
struct ClearanceTable {
  std::vector<double> clearance_m;  // [site]; +inf where nothing stands within reach
};

template <>
struct ArtifactTraits<ClearanceTable> {
  static constexpr std::string_view kName = "clearance-table";
  static constexpr std::uint32_t kVersion = 1;
};

Result<void> validate(const ClearanceTable& table);
Table dump(const ClearanceTable& table);
void encode(const ClearanceTable& table, ByteWriter& writer);
void decode(ByteReader& reader, ClearanceTable& table);

// Step 2, the options: each field once, with its unit, help and bounds.
struct MeasureClearanceOptions {
  double reach_m = 20.0;
  double lowest_m = -1.0;  // heights relative to the sensor
  double highest_m = 1.0;
};
std::vector<OptionField> option_fields(MeasureClearanceOptions& options);

inline constexpr std::uint32_t kMeasureClearanceVersion = 1;

// Step 3, the pass: the horizontal distance from each site to the nearest vertical plane (a class 2
// ND whose normal is within 30 degrees of level) with its mean between lowest_m and highest_m.
// Errors: mismatched-inputs (sites and map in different frames).
Result<ClearanceTable> measure_clearance(PassContext& ctx, const MeasureClearanceOptions& options,
                                         const NdtMap& map, const Sites& sites);

}  // namespace sightline

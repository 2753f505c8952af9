#pragma once

#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/sites.h"
#include "formats/surroundings/depth_images.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/virtual_scans.h"
#include "passes/pass/default_looks.h"
#include "passes/pass/pass.h"

namespace sightline {

struct ComputeFactorsOptions {
  std::vector<double> ranges_m = default_ranges_m();
};
std::vector<OptionField> option_fields(ComputeFactorsOptions& options);

// The map factors of every site at every range, as defined in schemas/definitions.md. The paper's:
// feature_count, d1_count, d2_count, d3_count, d1_ratio, d2_ratio, d3_ratio, occupancy_ratio,
// normal_entropy (bits), r_average (m), score_entropy (bits); and of the virtual scan: crlb_max,
// crlb_min (m), crlb_heading (of the weakest direction, degrees in [0, 180) from map +x), crlb_yaw
// (rad), hz_lmin, flat_050, virtual_points, virtual_error (m), rival_score. A site depends on NDs
// within its longest range plus 2 sqrt(2) m and two cells, the last two factors on NDs as far
// beyond that as the localizer strays, and on nothing else. Virtual points in no valid ND are
// counted in a warning. Errors: bad-value (ranges that do not ascend from above 0),
// mismatched-inputs (frames or sites that differ, or depth images or scans that end before the
// longest range).
Result<FactorTable> compute_factors(PassContext& ctx, const ComputeFactorsOptions& options,
                                    const NdtMap& map, const Sites& sites, const DepthImages& depth,
                                    const VirtualScans& scans);
inline constexpr Pass kComputeFactors{"compute-factors", 4, "map-factors", "Map factors",
                                      &compute_factors};

}  // namespace sightline

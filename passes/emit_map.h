#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/base/result.h"
#include "compiler/pipeline/options.h"
#include "compiler/pipeline/pass_context.h"
#include "formats/drive.h"
#include "formats/error_model.h"
#include "formats/factor_table.h"
#include "formats/map/compiled_map.h"
#include "formats/measured_error.h"
#include "formats/ndt_map.h"
#include "formats/predicted_error.h"
#include "formats/range_table.h"
#include "formats/sharpness.h"
#include "formats/sites.h"
#include "formats/trajectory.h"

namespace sightline {

inline constexpr std::uint32_t kEmitMapVersion = 6;

struct EmitMapOptions {
  std::string map_id;                 // empty: made of the mapping drive's content
  std::string version = "1";          // for people
  int release = 1;                    // only ever grows
  double reach_m = 10.0;              // a site farther away than this says nothing about a position
  std::string mapping_scans = "all";  // what the other passes were told: all, even, odd
  std::string localization_scans = "all";
  std::string localizer_used = "searching";  // by measure-error
  int coarse_cells_used = 1;
  double leaf_m = 1.0;
  double support_margin_used = 0.25;  // by predict-error
  bool extrapolated_longest_used = true;  // by choose-ranges
  bool has_factors = true;  // for engineers; no vehicle needs them
};
std::vector<OptionField> option_fields(EmitMapOptions& options);

struct EmitMapInputs {
  const Drive& mapping;
  const Drive& localization;
  const NdtMap& ndt;
  const Sites& sites;
  const PredictedError& predicted;
  const RangeTable& ranges;
  const MeasuredError& measured;
  const ErrorModel& model;
  const FactorTable& factors;
  const Sharpness* sharpness = nullptr;  // where it was measured
  const Trajectory* mapping_trajectory = nullptr;  // where its quality is to be kept
};

// Joins what the passes before it made into the map that is written to a file (encode_map). The
// map id names the mapping drive's content and frame, so that compiling the same recording again
// gives another release of the same map. Where predictions were told of an earlier drive, what it
// measured joins the factors (passes/learn/history.h, with_measured_columns). Warns of sites that were not measured.
// Errors: mismatched-inputs (sites, frames, ranges or limits differ), bad-value (version or id
// empty or not printable).
Result<CompiledMap> emit_map(PassContext& ctx, const EmitMapOptions& options,
                             const EmitMapInputs& inputs);

}  // namespace sightline

#pragma once

#include <vector>

#include "compiler/driver/plans.h"
#include "passes/localize/measure_error.h"

namespace sightline {

// The steps that localize one drive in a map. They are step 7 of a compile and most of an
// evaluation.

RecordingInput add_recording(Plan& plan, const RecordingRole& role,
                             const RecordingOptions& options);

Wire<Drive> ingest_drive(Plan& plan, const RecordingInput& input);

// The drive is estimated by itself, undistorted by its own motion and then aligned to the map.
LocalizedDrive add_drive(Plan& plan, const RecordingInput& input, Wire<NdtMap> ndt,
                         Wire<Sites> sites, bool may_be_elsewhere = false);

// A map that a drive is measured in, and how.
struct OnMap {
  Plan& plan;
  Wire<NdtMap> ndt;
  Wire<Sites> sites;
  MeasureErrorOptions measuring;
};

Wire<ByFamily<MeasuredError>> measure(std::string_view label, const LocalizedDrive& drive,
                                      const OnMap& on);

// As a localizer outside made them, where the configuration names a file of them.
Wire<ByFamily<MeasuredError>> add_errors(const CompileConfig& config, RecordingUse use,
                                         const LocalizedDrive& drive, const OnMap& on,
                                         std::vector<OutsideInput>& outside);

// Whether every second scan of the only mapping drive made the map, so that the others may judge
// it.
bool has_other_scans(const CompiledMap& map, const CompileConfig& config);

EvaluatePlan evaluate_plan(const CompileConfig& config, const CompiledMap& map);

}  // namespace sightline

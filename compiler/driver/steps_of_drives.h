#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "compiler/driver/plans.h"
#include "passes/localize/measure_error.h"
#include "passes/trajectory/align_drive.h"

// The steps of drives that are localized in a map; of pipelines.

namespace sightline {

// Which scans of the mapping drive make the map, and which are localized in it.
struct ScanShares {
  ScanSelection mapping = ScanSelection::kAll;
  ScanSelection localization = ScanSelection::kAll;
};

ScanShares scan_shares(const CompileConfig& config);

// Looks that take a sample are matched by this program's own localizers.
MeasureErrorOptions measuring_options(const CompileConfig& config, const Plan& plan);

// A map that a drive is measured in, and how.
struct OnMap {
  Plan& plan;
  Wire<NdtMap> ndt;
  Wire<Sites> sites;
  MeasureErrorOptions measuring;
};

// A recording that is taken from outside.
RecordingInput add_recording(Plan& plan, const std::string& role, const RecordingOptions& options);

// Its errors as a localizer outside made them, where `file` names them; else as ours makes them.
Wire<MeasuredError> add_errors(const CompileConfig& config, std::string_view label,
                               const LocalizedDrive& drive, const OnMap& on,
                               std::vector<OutsideInput>& outside);

// The steps of a drive that is localized in a map. One that may be elsewhere is kept where it is
// not found there.
LocalizedDrive add_drive(Plan& plan, const RecordingInput& input, Wire<NdtMap> ndt,
                         Wire<Sites> sites, bool may_be_elsewhere = false);

// The errors of the localization drive; where there are several, those of each by itself, joined.
// From here on `measured` speaks for all of them.
void add_localization_errors(const CompileConfig& config, const LocalizedDrive& first,
                             const OnMap& on, CompilePlan& compile);

// The scans that made the map, localized in it: they have the poses that they made it with. As
// evidence for the choice they are judged as the localization drive is, as a factor by those poses.
// `learns_here`: the model is to learn from the other scans of the same drive.
Wire<FactorTable> add_own_scans(const CompileConfig& config, const LocalizedDrive& mapping,
                                Wire<FactorTable> map_factors,
                                Wire<SensorProfile> localizing_sensor, bool learns_here,
                                CompilePlan& compile);

}  // namespace sightline

#pragma once

#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/annotation/outside_errors.h"
#include "formats/annotation/sites.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/default_looks.h"
#include "passes/pass/pass.h"

namespace sightline {

struct ImportErrorsOptions {
  std::vector<double> ranges_m = default_ranges_m();
  ScanSelection scans = ScanSelection::kAll;  // of the recording; others made the map
  double site_radius_m = 1.0;                 // the scan of a site lies no farther from it
};
std::vector<OptionField> option_fields(ImportErrorsOptions& options);

// What measure-error says of a drive, from errors that a localizer outside of this program made on
// its scans: each site takes the nearest scan that `outside` names, and of its errors the mean,
// median and so on over the starts at each range (schemas/definitions.md, "Measured error"). Work,
// time, iterations and the parts of an error stay 0: they were not imported. `trajectory` is that
// of `drive`, in any frame of the same world. Scans that no site takes are counted in a warning.
// Errors: mismatched-inputs, at the line (a scan that is not in the drive or made the map; a range
// that is none of the compile's; a scan without one of the ranges or starts that others have; a
// trajectory of another drive); no-overlap (no site has a scan near).
Result<ByFamily<MeasuredError>> import_errors(PassContext& ctx, const ImportErrorsOptions& options,
                                              const OutsideErrors& outside, const Drive& drive,
                                              const Trajectory& trajectory, const Sites& sites);
inline constexpr Pass kImportErrors =
    Pass{"import-errors", 2, "measured", "Errors of an external localizer", &import_errors}.in(
        Stage::kSites);

}  // namespace sightline

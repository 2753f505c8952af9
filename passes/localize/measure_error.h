#pragma once

#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/annotation/sites.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/tables/stored_table.h"
#include "passes/localize/tracking_starts.h"
#include "passes/matching/localizer.h"
#include "passes/matching/match_starts.h"
#include "passes/pass/default_looks.h"
#include "passes/pass/pass.h"

namespace sightline {

struct MeasureErrorOptions {
  std::vector<double> ranges_m = default_ranges_m();
  std::vector<Look> looks = default_looks();  // that take a sample; pcl-ndt takes its own
  // Ranges take every return, as the paper does; else what lies denser than voxels need is left
  // out.
  bool every_return = false;
  bool in_small_map = false;  // the NDs are those of a small map
  double leaf_m = 1.0;
  StartPattern starts{.count = 0};  // count 0: starts_of() says how many
  TrackingPattern tracking;
  int site_step = 0;  // every so many sites one is measured; 0: site_step_of() says
  ScanSelection scans = ScanSelection::kAll;
  double site_radius_m = 1.0;  // the scan of a site lies no farther from it
  // full-range: the match at the sensor's full range, the paper's choice; known: the poses given,
  // full-range where there are none (reference_of)
  ErrorReference reference = ErrorReference::kFullRangeMatch;
  LocalizerKind localizer = LocalizerKind::kSearching;  // "Localizers" in schemas/definitions.md
  int coarse_cells = 1;
  bool may_be_elsewhere = false;  // one of several drives: it need not come near any site
};
std::vector<OptionField> option_fields(MeasureErrorOptions& options);
// Of a pass that matches scans as measure-error does: `own` and, shared, those of its matching,
// which are measure-error's to say.
std::vector<OptionField> with_matching(std::vector<OptionField> own, MeasureErrorOptions& matching);

// 12 starts at every site; of pcl-ndt, whose matches take hundreds of times as long, 3 at every
// tenth.
StartPattern starts_of(const MeasureErrorOptions& options);
MatchStarts match_starts_of(const MeasureErrorOptions& options);
int site_step_of(const MeasureErrorOptions& options);

// What the errors of a drive with this trajectory can be measured against: poses that were
// estimated are matches to the very map, and no known ones.
ErrorReference reference_of(const MeasureErrorOptions& options, const Trajectory& trajectory);

// How scans are matched on a map of such cells.
MatchingCard matching_card(const MeasureErrorOptions& options, double cell_m);

// How far off the matcher ends when it localizes a drive at the sites of a map: at each site (or
// every site_step-th) the nearest scan is cut at every range and by every look, matched from
// every start and compared with the reference, as defined in schemas/definitions.md ("Measured
// error", v3; "Tracking starts", v2; "Errors by direction", v1). `trajectory` is that of
// `localization_drive`, in any frame of the same world. Sites without a scan near are counted in a
// warning and keep rows of zeros; another warning names the scans that have no known poses to
// measure against. pcl-ndt needs has_pcl_ndt(). Errors: mismatched-inputs (trajectory and drive, or
// map and sites, do not belong together), empty-map, no-overlap (no site has a scan near, unless
// the drive may be elsewhere), what reading a scan returns, bad-value (TrackingPattern), and
// disk-full or cannot-write (a temporary file).
Result<ByFamily<StoredTable<MeasuredError>>> measure_error(PassContext& ctx,
                                                           const MeasureErrorOptions& options,
                                                           const Drive& localization_drive,
                                                           const Trajectory& trajectory,
                                                           const TiledNds& nds, const Sites& sites);
inline constexpr Pass kMeasureError =
    Pass{"measure-error", 16, "measured", "Localization error of a drive", &measure_error}
        .in(Stage::kSites)
        .with({.scan_s = 0.018});

}  // namespace sightline

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/localize/tracking_starts.h"
#include "passes/matching/scan_cutter.h"
#include "passes/pass/pass_context.h"

// Numbers of the filters before PCL's NDT that suit a route ("Tuning an NDT" in
// schemas/definitions.md). The NDT itself is left as it is.

namespace sightline {

// Box, voxel and count of points of all combinations that are tried, ascending.
std::vector<AutowareFilters> filters_to_try();

struct TuneNdtOptions {
  // Those of a box and voxel behind each other; Autoware's own are among them.
  std::vector<AutowareFilters> filters = filters_to_try();
  std::vector<double> limits_m = {0.10, 0.25};
  std::size_t limit = 0;  // of these, by which numbers are chosen
  ScanSelection scans = ScanSelection::kAll;
  // full-range: this program's own match at the sensor's full range; known: the poses given.
  ErrorReference reference = ErrorReference::kFullRangeMatch;
  double site_radius_m = 1.0;   // scans farther from every site are not used
  std::size_t most_scans = 48;  // at least 2; half of them choose, half judge
  TrackingPattern tracking;     // where each scan is matched from
};

// Means over matches.
struct NdtFigures {
  std::vector<double> within_share;  // one a limit: ended so near the reference
  double lost_share = 0.0;           // ended farther than 0.5 m off
  double error_m = 0.0;
  double point_count = 0.0;  // that were matched
  double work = 0.0;         // points x iterations
  double time_ms = 0.0;      // CPU time of filters and match; not the same in two runs
};

struct TriedFilters {
  AutowareFilters filters;
  NdtFigures figures;
};

struct NdtTuning {
  std::string drive;
  double cell_m = 0.0;  // of the map: the NDT's resolution
  ErrorReference reference = ErrorReference::kFullRangeMatch;
  std::vector<double> limits_m;
  std::size_t limit = 0;
  std::size_t start_count = 0;          // of each scan
  std::size_t choosing_scan_count = 0;  // scans by which numbers were chosen
  std::size_t judging_scan_count = 0;   // others
  // Every combination, in their order, on the scans that choose.
  std::vector<TriedFilters> tried;
  // On the scans that judge: Autoware's own numbers; the least work of those that end within
  // the limit as often and lose no more; and the most within the limit, of equals with the least
  // work.
  TriedFilters defaults;
  TriedFilters cheapest;
  TriedFilters best;

  // Whether the scans that judge confirm it: at most one point less within the limit, no more lost,
  // and at least a tenth less work; more than one point more within the limit.
  [[nodiscard]] bool is_cheaper() const;
  [[nodiscard]] bool is_better() const;
};

// Matches scans of a drive, evenly along it, by PCL's NDT from tracking starts, after every
// combination of the filters' numbers. `trajectory` is that of the drive, in any frame of the same
// world. Needs has_pcl_ndt(). The same figures for any number of threads, but times. Errors:
// mismatched-inputs (trajectory and drive, or map and sites, do not belong together), empty-map,
// no-overlap (fewer than two scans are near sites), bad-value (TrackingPattern), and what reading a
// scan returns.
Result<NdtTuning> tune_ndt(const PassContext& ctx, const TuneNdtOptions& options,
                           const Drive& drive, const Trajectory& trajectory, const TiledNds& nds,
                           const Sites& sites);

}  // namespace sightline

#pragma once

#include <vector>

#include "formats/annotation/calibrated_plan.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/localize/measure_error.h"
#include "passes/pass/pass.h"

namespace sightline {

struct CalibratePlanOptions {
  double doubted_share = 0.02;   // of good first looks, that may be doubted
  double good_m = 0.05;          // a first look no farther off is good
  double reach_m = 10.0;         // a site farther away than this says nothing; the map's own
  MeasureErrorOptions matching;  // which scans are matched, in which voxels
};
std::vector<OptionField> option_fields(CalibratePlanOptions& options);

// What a first look said of itself, and how far off it truly was.
struct FirstLook {
  double doubt = 0.0;
  double error_m = 0.0;
};
SIGHTLINE_FIELDS(FirstLook, doubt, error_m)

// The threshold of a plan for a street where first looks did like that: as calibrate_plan() sets
// it.
double raised_threshold(const CalibratePlanOptions& options, const LookPlan& plan,
                        const std::vector<FirstLook>& looks);

// Sets the threshold at which a vehicle takes a second look. The probability p* of chosen ranges is
// set by passes/model/promise/calibration.h.
//
// The usual plan (passes/pass/default_looks.h), whose test was learnt in generated towns, with a
// threshold for this map's street: on a real one, whose walls are no planes, good matches score
// less, and the learnt threshold doubts most of them. Each scan of the drive is matched by the
// first look of its place from where the two before it predict it; the threshold is raised until
// at most doubted_share of the good ones lie above it, but stays below the doubt of every one that
// is more than the plan's limit off, and is never below the learnt one. Without looks: no plan.
// With fewer than 10 good scans the learnt threshold stays. Errors: mismatched-inputs (drive and
// trajectory, or map, sites and ranges, do not belong together), empty-map, and what reading a scan
// says.
Result<CalibratedPlan> calibrate_plan(PassContext& ctx, const CalibratePlanOptions& options,
                                      const Drive& drive, const Trajectory& trajectory,
                                      const TiledNds& nds, const Sites& sites,
                                      const ByFamily<RangeTable>& ranges);
inline constexpr Pass kCalibratePlan =
    Pass{"calibrate-plan", 3, "plan", "Threshold for a second scan sample while tracking",
         &calibrate_plan}
        .in(Stage::kLearn)
        .with({.scan_s = 0.0003, .million_points_s = 0.04});

}  // namespace sightline

#pragma once

#include <cstddef>
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
  double good_m = 0.05;          // a look no farther off is good
  double reach_m = 10.0;         // a site farther away than this says nothing; the map's own
  MeasureErrorOptions matching;  // which scans are matched, in which voxels
};
std::vector<OptionField> option_fields(CalibratePlanOptions& options);

// How far off the result of a scan was, and its points times iterations.
struct TriedResult {
  double error_m = 0.0;
  double work = 0.0;
};
SIGHTLINE_FIELDS(TriedResult, error_m, work)

// A scan matched by the plan's first look alone, by that and a second look (their work together),
// which is cheaper_second_look() or the plan's own, and by the map's look at that place; all from
// the same prediction.
struct TriedScan {
  double doubt = 0.0;  // of the first look
  TriedResult first;
  TriedResult with_cheaper;
  TriedResult with_own;
  TriedResult look;
};
SIGHTLINE_FIELDS(TriedScan, doubt, first, with_cheaper, with_own, look)

// The threshold of a plan for a street where first looks did like that: as calibrate_plan() sets
// it.
double raised_threshold(const CalibratePlanOptions& options, const LookPlan& plan,
                        const std::vector<TriedScan>& scans);

// Whether cheaper_second_look() is good for at least as many of the doubted scans as the plan's own
// second look. Never where fewer than 20 are doubted.
bool is_cheaper_as_good(const CalibratePlanOptions& options, const LookPlan& plan,
                        const std::vector<TriedScan>& scans);

// Whether the map's looks keep at least as many of the scans within the plan's limit, with less
// than two thirds of its work. Never for fewer than 10 scans.
bool is_dearer_than_looks(const LookPlan& plan, const std::vector<TriedScan>& scans);

// Sets the threshold at which a vehicle takes a second look. The probability p* of chosen ranges is
// set by passes/model/promise/calibration.h.
//
// The usual plan (passes/pass/default_looks.h), whose test was learnt in generated towns, with a
// threshold for this map's street: on a real one, whose walls are no planes, good matches score
// less, and the learnt threshold doubts most of them. Each scan of the drive is matched by the
// first look of its place from where the two before it predict it; the threshold is raised until
// at most doubted_share of the good ones lie above it, but stays below the doubt of every one that
// is more than the plan's limit off, and is never below the learnt one. With fewer than
// 10 good scans the learnt threshold stays. Where many are doubted, a cheaper second look
// that is as good for them replaces the plan's. No plan: without looks, and where it is dearer than
// the map's looks, which then hold while tracking too. Errors: mismatched-inputs (drive and
// trajectory, or map, sites and ranges, do not belong together), empty-map, and what reading a scan
// says.
Result<CalibratedPlan> calibrate_plan(PassContext& ctx, const CalibratePlanOptions& options,
                                      const Drive& drive, const Trajectory& trajectory,
                                      const TiledNds& nds, const Sites& sites,
                                      const ByFamily<RangeTable>& ranges);
inline constexpr Pass kCalibratePlan =
    Pass{"calibrate-plan", 4, "plan", "Threshold for a second scan sample while tracking",
         &calibrate_plan}
        .in(Stage::kLearn)
        .with({.scan_s = 0.0003, .million_points_s = 0.04});

}  // namespace sightline

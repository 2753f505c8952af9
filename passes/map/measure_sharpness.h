#pragma once

#include <Eigen/Core>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/surroundings/sharpness.h"
#include "passes/pass/pass.h"

namespace sightline {

struct MeasureSharpnessOptions {
  double radius_m = 0.5;     // around a point, for entropy
  double cell_m = 2.0;       // of the NDs whose thickness is judged
  double scan_step_m = 2.0;  // of the way between the scans that are laid on each other
  double reach_m = 30.0;     // returns farther from the sensor take no part
};
std::vector<OptionField> option_fields(MeasureSharpnessOptions& options);

// How sharp the drive's scans are when the trajectory lays them on each other, and when the poses
// that came with the drive do, where every scan taken has one ("Sharpness" in
// schemas/definitions.md, v1). Errors: mismatched-inputs (the trajectory is not of the drive) and
// what reading a scan says.
Result<Sharpness> measure_sharpness(PassContext& ctx, const MeasureSharpnessOptions& options,
                                    const Drive& drive, const Trajectory& trajectory);
inline constexpr Pass kMeasureSharpness{"measure-sharpness", 2, "sharpness", "How sharp the map is",
                                        &measure_sharpness};

// Of points that are laid already; their order decides nothing but last bits, threads nothing.
SharpnessFigures sharpness_of(const std::vector<Eigen::Vector3d>& points_m,
                              const MeasureSharpnessOptions& options, int threads);

}  // namespace sightline

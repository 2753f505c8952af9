#pragma once

#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/surroundings/sharpness.h"
#include "passes/map/sharpness/point_sharpness.h"
#include "passes/pass/pass.h"

namespace sightline {

std::vector<OptionField> option_fields(MeasureSharpnessOptions& options);

// How sharp the drive's scans are by the trajectory, and by the poses that came with the drive,
// where every scan taken has one ("Sharpness" in schemas/definitions.md, v2). Errors:
// mismatched-inputs (the trajectory is not of the drive) and those of reading a scan.
Result<Sharpness> measure_sharpness(PassContext& ctx, const MeasureSharpnessOptions& options,
                                    const Drive& drive, const Trajectory& trajectory);
inline constexpr Pass kMeasureSharpness =
    Pass{"measure-sharpness", 4, "sharpness", "Sharpness of the map", &measure_sharpness}
        .in(Stage::kTiles)
        .with({.million_points_s = 0.05});

}  // namespace sightline
